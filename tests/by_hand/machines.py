"""Graphs with a digital part, and what their Verilog gives against what the simulation gave."""

from fractions import Fraction
from typing import Any

from proofmass.blocks import FixedDifference, FixedGain, FixedIntegrator, FixedQuantiser, FixedToNumber, Sine
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.bench.vectors import Vectors, simulated
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.text.machine_verilog import machine_text
from tests.by_hand.verilog import ModuleByHand


def loop_at_rates(error: int = 6000, gain: int = 3000, integrator: int = 2000) -> Graph:
    """A loop in fixed point whose blocks tick at rates of their own, in hertz."""
    rates = {"setpoint": 6000, "quantiser": 6000, "error": error, "gain": gain, "integrator": integrator}
    return Graph(
        name="loop",
        rate=6000,
        duration="20 ms",
        blocks={
            "setpoint": Sine(amplitude=2.5, frequency=300.0),
            "quantiser": FixedQuantiser(),
            "error": FixedDifference(output_format=Fixed(17, 12)),
            "gain": FixedGain(gain=0.75, input_format=Fixed(17, 12)),
            "integrator": FixedIntegrator(gain=700.0, output_unit="1"),
            "number": FixedToNumber(),
        },
        rates={name: Fraction(rate) for name, rate in rates.items()},
        wires=[
            "setpoint.output -> quantiser.input",
            "quantiser.output -> error.first",
            "integrator.output -> error.second",
            "error.output -> gain.input",
            "gain.output -> integrator.input",
            "integrator.output -> number.input",
        ],
        probes=["error.output", "integrator.output"],
    )


def made(graph: Graph, *only: str, clocks: int | None = None) -> tuple[Machine, Vectors]:
    """The machine of a graph, and vectors of its simulation."""
    planned = plan(graph, wide=True)
    machine = compose(planned, only, "top")
    return machine, simulated(planned, machine, clocks)


def differences(machine: Machine, vectors: Vectors) -> list[Any]:
    """Clocks in which an output of the text is another than that of the simulation, and what it is."""
    hardware = ModuleByHand(machine_text(machine))
    if machine.clocked:
        hardware.clock({}, reset=1)
    wrong, late = [], machine.latency
    for n in range(vectors.clocks + late):
        given = {name: int(column[min(n, vectors.clocks - 1)]) for name, column in vectors.inputs.items()}
        found = hardware.clock(given)
        if n >= late:
            expected = {name: int(column[n - late]) for name, column in vectors.outputs.items()}
            if any(found[name] != value for name, value in expected.items()):
                wrong.append((n, found, expected))
    return wrong
