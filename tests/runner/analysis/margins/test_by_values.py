"""Derivatives by named values against differences of whole graphs, and against those by the parameters that follow."""

import pytest

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.analysis.margins.sensitivity import margin_sensitivities, transfer_sensitivities
from proofmass.runner.planning.plan import plan

GRAPH = read_graph_text(
    """\
name = "a loop with one mass in three parameters"
rate = "10 kHz"
wires = [
    "push.output -> difference.first",
    "controller.output -> difference.second",
    "difference.output -> sensor.force",
    "sensor.displacement -> readout.displacement",
    "readout.voltage -> controller.error",
]

[values]
mass = "1 mg"
resonance = "200 Hz"
stiffness = "= mass * (2 * pi * resonance)^2"
sensitivity = "2 V/um"

[blocks]
push = { kind = "Constant", value = "= mass * 9.81 m/s^2", unit = "N" }
difference = { kind = "Difference", unit = "N" }
readout = { kind = "DisplacementReadout", gain = "= sensitivity" }

[blocks.sensor]
kind = "MassSpringDamper"
mass = "= mass"
stiffness = "= stiffness"
damping = "= sqrt(mass * stiffness)"

[blocks.controller]
kind = "PID"
proportional = "0.2 uN/V"
integral = "= 0.5 uN/V * resonance"
derivative_gain = 0
input_unit = "V"
output_unit = "N"
"""
)
NODES = "push.output", "readout.voltage"
STEP = 1e-5


def values_of(graph: Graph) -> dict[str, float]:
    planned = plan(graph)
    source, target = (node_of(planned, signal) for signal in NODES)
    about, signal = linearised(planned), "controller.output"
    loop = margins_of(about.loop(node_of(planned, signal)), "main", signal).as_data()
    found = {each.quantity: each.value for each in transfer_sensitivities(about, source, target)}
    return found | {"main: gain margin": loop["gain_margin_db"], "main: phase margin": loop["phase_margin_deg"]}


def slopes_of(graph: Graph) -> dict[str, dict[str, float]]:
    planned = plan(graph)
    about = linearised(planned)
    source, target = (node_of(planned, signal) for signal in NODES)
    node = node_of(planned, "controller.output")
    system = about.loop(node, by_parameters=True)
    of_margins = margin_sensitivities(planned, margins_of(about.loop(node), "main", "controller.output"), system)
    found = [*transfer_sensitivities(about, source, target), *of_margins]
    return {each.quantity: {effect.parameter: effect.derivative for effect in each.effects} for each in found}


@pytest.fixture(scope="module")
def exact() -> dict[str, dict[str, float]]:
    return slopes_of(GRAPH)


@pytest.mark.parametrize("name", ["mass", "resonance", "sensitivity"])
def test_derivatives_are_those_of_differences(name: str, exact: dict[str, dict[str, float]]) -> None:
    base = GRAPH.values[name].number
    above, below = (values_of(GRAPH.with_parameters({name: base * (1 + sign * STEP)})) for sign in (1, -1))
    nominal = values_of(GRAPH)
    for quantity in nominal:
        expected = (above[quantity] - below[quantity]) / (2 * STEP * base)
        assert exact[quantity].get(name, 0.0) == pytest.approx(
            expected, rel=1e-5, abs=1e-6 * abs(nominal[quantity] / base)
        )
    assert name in exact["main: gain margin"]


def test_a_value_has_the_sum_of_its_parameters(exact: dict[str, dict[str, float]]) -> None:
    by = exact["main: gain margin"]
    mass, k = GRAPH.values["mass"].number, GRAPH.values["stiffness"].number
    parameters = by["sensor.mass"] + by["sensor.stiffness"] * k / mass + by["sensor.damping"] * (k / mass) ** 0.5
    assert by["mass"] == pytest.approx(parameters, rel=1e-12)
    assert by["stiffness"] == pytest.approx(by["sensor.stiffness"] + by["sensor.damping"] * (mass / k) ** 0.5 / 2)
