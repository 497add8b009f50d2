"""Figures of responses that do not settle, and of loops that pass nothing at rest.

1 / (j w) of an integrator is without limit at rest, and known elsewhere.
"""

import math
from typing import Any

import pytest

from proofmass import Graph, margins, response
from proofmass.blocks import Butterworth, Constant, DiscreteIntegrator, Gain, Negation, UnitDelay
from proofmass.graphs.model.quantities import ResponseFigure
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.design.quantities.loop_figures import NoValue, Reading
from proofmass.runner.design.quantities.output_figures import read_response
from proofmass.runner.planning.plan import plan
from proofmass.runner.verification.verify import Measurements, verify


def read(figure: str, frequency: float | None = None) -> Reading | NoValue:
    blocks: dict[str, Any] = {"push": Constant(), "sum": DiscreteIntegrator()}
    planned = plan(Graph(name="", rate=1000, blocks=blocks, wires=["push.output -> sum.input"]))
    wanted = ResponseFigure(figure, "sum.output", "push.output", frequency, "")
    return read_response(OperatingPoints(planned), wanted, {}, False)


@pytest.mark.defect(
    "S1087", before="a peak of 318 at 0.5 mHz, where a picture begins: met by at_most = 400", after="does not settle"
)
@pytest.mark.parametrize(("figure", "frequency"), [("peak", None), ("bandwidth", None), ("delay", None), ("gain", 0.0)])
def test_what_does_not_settle_has_no_figure_of_all_frequencies(figure: str, frequency: float | None) -> None:
    assert read(figure, frequency) == NoValue("what push.output does to sum.output does not settle")


@pytest.mark.defect("S1093", before="`response` gave an integrator a bandwidth of 0.7 mHz", after="none")
def test_an_integrator_has_no_bandwidth() -> None:
    blocks: dict[str, Any] = {"push": Constant(), "sum": DiscreteIntegrator()}
    found = response(
        Graph(name="", rate=1000, blocks=blocks, wires=["push.output -> sum.input"]), "push.output", "sum.output"
    )
    assert found.corners == (None, None)
    assert "  bandwidth         none" in str(found)


def test_it_has_a_gain_at_a_frequency() -> None:
    """T / |z - 1| = T / (2 sin(pi f T))."""
    found = read("gain", 10.0)
    assert isinstance(found, Reading)
    assert found.value == pytest.approx(1e-3 / (2.0 * math.sin(math.pi * 1e-2)), rel=1e-9)


@pytest.mark.defect(
    "S1092", before="a high-pass in a loop: T(0) = 1e-17, and a bandwidth of half the rate", after="no bandwidth"
)
def test_a_loop_that_passes_nothing_at_rest_has_no_bandwidth() -> None:
    loop = Graph(
        name="",
        rate="10 kHz",
        samples=2,
        blocks={
            "high": Butterworth(order=1, high_pass=True, corner_frequency=10.0),
            "low": Butterworth(order=1, corner_frequency=100.0),
            "gain": Gain(gain=3.0),
            "late": UnitDelay(),
            "minus": Negation(),
        },
        wires=[
            "minus.output -> high.input",
            "high.output -> low.input",
            "low.output -> gain.input",
            "gain.output -> late.input",
            "late.output -> minus.input",
        ],
        loops={"main": {"open_at": "gain.output"}},
        requirements={"R": {"quantity": {"loop": "main", "figure": "bandwidth"}, "at_least": "1 Hz"}},
    )
    assert margins(loop).bandwidth is None
    (found,) = verify(Measurements(loop, None, "python"))
    assert not found.met
    assert found.reason == "the loop main passes nothing at rest, and has no bandwidth"
