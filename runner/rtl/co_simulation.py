"""The engine `cxxrtl`: the Verilog of the digital part runs beside the rest of the graph, which is interpreted.

In every tick the interpreter asks the compiled model for the outputs of digital blocks, once their inputs are there;
where it would step those blocks it clocks the model. The model has no count of overflows.
"""

from collections.abc import Callable, Iterator
from typing import Any

from proofmass.blocks.problem import ModelError, Problem
from proofmass.graphs.graph import split
from proofmass.graphs.schedule import Node
from proofmass.runner.engine.interpret import Interpreter
from proofmass.runner.engine.memory import Memory
from proofmass.runner.engine.planned import Plan
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.rtl.compose import compose
from proofmass.runner.rtl.cxxrtl import Model
from proofmass.runner.rtl.machine import Machine
from proofmass.runner.rtl.machine_verilog import machine_text
from proofmass.runner.rtl.reference import reference_of
from proofmass.runner.rtl.words import Port


class CoSimulation(Interpreter):
    """The interpreter with a model in the place of the digital blocks."""

    name = "cxxrtl"

    def __init__(self, plan: Plan, seed: int, run: int = 0, memory: Memory | None = None) -> None:
        self._machine = compose(plan)
        if self._machine.latency:
            message, got = (
                "hardware with pipeline cuts is late, and the graph would see that",
                f"{self._machine.latency} ticks",
            )
            hint = "run it with --engine python, and the hardware in its bench"
            raise ModelError([Problem(message=message, got=got, hint=hint)])
        self._paths = {instance.path for instance in self._machine.instances}
        self._model = Model(reference_of(plan, self._machine), machine_text(self._machine))
        self._clock = int(plan.schedule.base_rate / self._machine.rate)  # ticks from one to the next
        self._given: list[int] = []  # inputs that the model has settled for
        self._found: dict[str, int] | None = None  # outputs for these, since its last clock
        self._inputs = [(_node(port), port.text) for port in self._machine.inputs]
        super().__init__(plan, seed, run, memory)
        self._model.held = list(_held(self._machine, self._memory, self._clock))
        asked = {_node(port) for port in self._machine.outputs}
        self._outputs = [each for each in self._outputs if each[0][0] not in self._paths or each[0] in asked]
        self._updates = [each for each in self._updates if each[0] not in self._paths]

    def memory(self) -> Memory:
        """What moves, as it stands; without counts of overflows, which hardware does not keep."""
        self._read_registers()
        self._memory.overflows.clear()
        return self._memory

    def snapshot(self) -> Callable[[], Memory]:
        """What moves, kept as it is now."""
        kept = self.memory().copy()
        return lambda: kept

    def _output(self, name: str, port: str) -> Callable[[int], Any]:
        if name not in self._paths:
            return super()._output(name, port)
        block = self.plan.blocks[name]
        declared = block.outputs[port]
        kind, signal = held_as(declared.dtype), f"{name}.{port}"
        if not declared.shape:
            return lambda tick: kind(self._settled()[signal])
        size = block.shape_of(declared)[0]
        return lambda tick: [kind(self._settled()[f"{signal}[{i}]"]) for i in range(size)]

    def _move(self, tick: int) -> None:
        if tick % self._clock == 0:
            if self._wires() != self._given:
                self._settled()
            self._model.clock()
            self._found = None
        super()._move(tick)

    def _settled(self) -> dict[str, int]:
        """Outputs of the model by their signals, for what the wires hold."""
        given = self._wires()
        if self._found is None or given != self._given:
            values = self._model.settled(given)
            self._found = {port.text: value for port, value in zip(self._machine.outputs, values, strict=True)}
            self._given = given
        return self._found

    def _wires(self) -> list[int]:
        wires = self._memory.wires
        return [_entry(wires[node], text) for node, text in self._inputs]

    def _read_registers(self) -> None:
        """States and buffers of the digital blocks, from the registers of the model."""
        held = iter(self._model.held)
        for instance in self._machine.instances:
            for register, value in zip(instance.module.registers, held, strict=False):
                head, _, field = register.text.partition(".")
                if head == "x":
                    state = self._memory.states[instance.path]
                    kind = type(getattr(state, field))
                    self._memory.states[instance.path] = state._replace(**{field: kind(value)})
                else:
                    buffer: Any = self._memory.buffers[instance.path, register.text.partition("[")[0]]
                    buffer[_place(register.text)] = value


def _held(machine: Machine, memory: Memory, ticks: int) -> Iterator[int]:
    """What the registers of a machine hold, in the order of its reference."""
    for instance in machine.instances:
        state = memory.states.get(instance.path)
        fields = getattr(state, "_fields", ())
        known = {f"x.{field}": value for field, value in zip(fields, state or (), strict=True)}
        for register in instance.module.registers:
            buffer = memory.buffers.get((instance.path, register.text.partition("[")[0]))
            yield int(known[register.text] if buffer is None else buffer[_place(register.text)])
    if machine.single:
        return
    for net in machine.nets.values():
        if net.kept:
            yield _entry(memory.wires[split(net.signal.partition("[")[0])], net.signal)
    clocks = -(-memory.tick // ticks)
    for _, over, last in machine.counters:
        yield -(-clocks // over) % (last + 1)


def _node(port: Port) -> Node:
    return split(port.text.partition("[")[0])


def _place(text: str) -> int:
    return int(text.partition("[")[2].rstrip("]"))


def _entry(value: Any, text: str) -> int:
    return int(value[_place(text)] if "[" in text else value)
