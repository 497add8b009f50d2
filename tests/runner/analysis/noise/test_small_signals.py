"""Notes where noise is not small, against the moments of a square and in a linear graph."""

import math

import numpy as np
import pytest

from proofmass import Graph, noise, simulate
from proofmass.blocks import Constant, LowPass, Product, Sum, WhiteNoise


def squared(constant: float) -> Graph:
    """The square of a constant and noise of 1 V rms, through a filter that hardly filters."""
    blocks = {
        "white": WhiteNoise(density=math.sqrt(2e-3), unit="V"),
        "constant": Constant(value=constant, unit="V"),
        "sum": Sum(unit="V"),
        "filter": LowPass(corner_frequency=400.0, input_unit="V", output_unit="V"),
        "square": Product(first_unit="V", second_unit="V"),
    }
    wires = [
        "white.output -> sum.first", "constant.output -> sum.second", "sum.output -> filter.input",
        "filter.output -> square.first", "filter.output -> square.second",
    ]  # fmt: skip
    return Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=["square.output", "filter.output"])


@pytest.mark.parametrize(("constant", "small"), [(0.01, False), (100.0, True)])
def test_the_square_of_noise(constant: float, small: bool) -> None:
    """Of x + n with n of variance v it has the variance 4 x^2 v + 2 v^2, of which a budget knows the first."""
    graph = squared(constant)
    budget = noise(graph, "square.output", at="0.1 s")
    assert (not any("noise is not small" in note for note in budget.notes)) == small
    values = simulate(graph, samples=20_000)["square.output"].values[100:]
    assert (abs(np.std(values) / budget.rms - 1.0) < 0.1) == small


def test_a_linear_graph_has_no_note() -> None:
    assert noise(squared(0.01), "filter.output", at="0.1 s").notes == ()
