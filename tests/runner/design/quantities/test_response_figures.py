"""Figures of responses that do not settle: 1 / (j w) of an integrator is without limit at rest, and known elsewhere."""

import math
from typing import Any

import pytest

from proofmass import Graph
from proofmass.blocks import Constant, DiscreteIntegrator
from proofmass.graphs.model.quantities import ResponseFigure
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.design.quantities.loop_figures import NoValue, Reading
from proofmass.runner.design.quantities.output_figures import read_response
from proofmass.runner.planning.plan import plan


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


def test_it_has_a_gain_at_a_frequency() -> None:
    """T / |z - 1| = T / (2 sin(pi f T))."""
    found = read("gain", 10.0)
    assert isinstance(found, Reading)
    assert found.value == pytest.approx(1e-3 / (2.0 * math.sin(math.pi * 1e-2)), rel=1e-9)
