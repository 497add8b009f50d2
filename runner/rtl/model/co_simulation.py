"""The engine `cxxrtl`: the compiled loop with a model of the Verilog for the digital blocks."""

from dataclasses import replace

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.machine.reference import reference_of
from proofmass.runner.rtl.model.cxxrtl import VerilogModel
from proofmass.runner.rtl.model.hardware_loop import HardwareTickWriter
from proofmass.runner.rtl.text.machine_verilog import machine_text
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan


class CoSimulation(CompiledLoop):
    """A run with hardware in the loop; overflows of blocks in hardware are not counted."""

    name = "cxxrtl"

    def __init__(self, plan: Plan, seed: int, run: int, memory: Memory) -> None:
        machine = compose(plan)
        if machine.latency:
            message = "hardware with pipeline cuts is late, and the graph would see that"
            got, hint = f"{machine.latency} ticks", "run it with --engine python, and the hardware in its bench"
            raise Problem(message=message, got=got, hint=hint).error
        self._model = VerilogModel(reference_of(plan, machine), machine_text(machine))
        paths = {instance.path for instance in machine.instances}
        beside = replace(plan, digital={name: block for name, block in plan.digital.items() if name not in paths})
        written = HardwareTickWriter(beside, machine, self._model).written()
        super().__init__(beside, seed, run, memory, CompiledPlan(beside, written))
