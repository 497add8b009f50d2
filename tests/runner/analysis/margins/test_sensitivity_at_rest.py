"""Derivatives of margins of loops that rest elsewhere with another parameter, in closed form.

The quadratic loop rests where c1 x + c2 x^2 = u, with the slope s = c1 + 2 c2 x there, so that dx/du = 1 / s. Its gain
margin is 2 / (k s). That of the demodulated loop is 2 / (k (1 + x1)), where 1 + x1 = sqrt(1 + 4 u).
"""

import math

import pytest

from proofmass import margins
from proofmass.blocks import Constant, Difference, DiscreteIntegrator, LookUpTable
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Graph as PlainGraph
from proofmass.runner.analysis.linearisation.linearisation import At, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.analysis.margins.sensitivity import margin_sensitivities
from proofmass.runner.planning.plan import plan
from tests.by_hand.orbiting_loops import DEMODULATED, demodulated_margin
from tests.by_hand.resting_loops import quadratic_loop, quadratic_rest

DECIBELS = 20.0 / math.log(10.0)  # of a relative change


def of_gain_margin(graph: PlainGraph, signal: str, at: At) -> dict[str, float]:
    """Return the derivatives of the gain margin in dB."""
    planned = plan(graph)
    system = OperatingPoints(planned, at).loop(node_of(planned, signal), by_parameters=True)
    gain, *_ = margin_sensitivities(planned, margins_of(system, "main", signal), system)
    return {effect.parameter: effect.derivative for effect in gain.effects}


@pytest.mark.defect("S846", before="the read wire stood still: -1.2 dB for each unit of the level", after="-1.74 dB")
@pytest.mark.parametrize("signal", ["plant.output", "error.output"])
@pytest.mark.parametrize("at", ["settled", "10 s"])
def test_a_loop_rests_elsewhere_with_another_parameter(signal: str, at: str) -> None:
    """At 10 s the point is followed as one of rest, earlier through all ticks from the start."""
    u, x = 2.0, quadratic_rest(2.0)
    s = 1.0 + x
    by_slope = {"level.value": 1.0 / s, "curve.c1": 1.0 - x / s, "curve.c2": 2.0 * x - x * x / s}
    derivatives = of_gain_margin(quadratic_loop(), signal, at)
    assert margins(quadratic_loop(), signal, at=at).gain_margin == pytest.approx(2.0 / (0.1 * s), rel=1e-9)
    for parameter, moved in by_slope.items():
        assert derivatives[parameter] == pytest.approx(-DECIBELS * moved / s, rel=1e-6), u
    assert derivatives["gain.gain"] == pytest.approx(-DECIBELS / 100.0, rel=1e-6)


@pytest.mark.defect(
    "S848", before="entries of a table had no derivatives about a late point", after="those of its slope"
)
@pytest.mark.parametrize("at", ["0.1 s", "settled", "20 s"])
def test_entries_of_a_table_move_its_slope(at: str) -> None:
    """x' = x + 0.1 f(1 - x) rests where f = 0, with the slope s of two entries: the limit is 2 / (0.1 s)."""
    blocks: dict[str, Block] = {
        "level": Constant(value=1.0), "error": Difference(),
        "curve": LookUpTable(breakpoints=(-2.0, -1.0, 1.0, 2.0), values=(-9.0, -3.0, 5.0, 9.0)),
        "plant": DiscreteIntegrator(gain=100.0, output_unit="1"),
    }  # fmt: skip
    wires = ["level.output -> error.first", "plant.output -> error.second", "error.output -> curve.input"]
    graph = Graph(name="table", rate=1000, blocks=blocks, wires=[*wires, "curve.output -> plant.input"])
    derivatives = of_gain_margin(graph, "plant.output", at)
    rise, run = 8.0, 2.0
    expected = {
        "values[1]": -1.0 / rise,
        "values[2]": 1.0 / rise,
        "breakpoints[1]": 1.0 / run,
        "breakpoints[2]": -1.0 / run,
    }
    for entry, part in expected.items():
        assert derivatives[f"curve.{entry}"] == pytest.approx(-DECIBELS * part, rel=1e-9)


@pytest.mark.defect("S847", before="derivatives of the start, of a graph that has settled", after="of where it settles")
def test_an_orbit_moves_with_a_parameter() -> None:
    derivatives = of_gain_margin(read_graph_text(DEMODULATED), "plant.output", "auto")
    assert derivatives["level.value"] == pytest.approx(-DECIBELS * 2.0 / 5.0, rel=1e-6)
    assert math.isclose(demodulated_margin(1.0, 100.0), 2.0 / (0.1 * math.sqrt(5.0)), rel_tol=1e-12)
