"""Rates without a common base rate: the rate that the hint names is one that goes."""

import re

import pytest

from proofmass import Graph, check
from proofmass.blocks import UnitDelay
from proofmass.blocks.declaration.problem import Problem

MESSAGE = "the rates have no common base rate within reach"


def refused(rates: dict[str, str], rate: str | None) -> list[Problem]:
    blocks = {name: UnitDelay() for name in ("first", "second")}
    graph = Graph(name="", rate=rate, blocks=blocks, wires=["first.output -> second.input"], rates=rates)
    return [problem for problem in check(graph) if problem.message == MESSAGE]


@pytest.mark.parametrize("rate", [None, "1 kHz", "123 Hz"])
@pytest.mark.parametrize(
    ("far", "near"),
    [
        ("1000.000123457 Hz", "1 kHz"),
        ("3141.592653589793 Hz", "3 kHz"),
        ("27.18281828459045 Hz", "1000/37 Hz"),
    ],
)
def test_the_hint_names_a_rate_that_goes(rate: str | None, far: str, near: str) -> None:
    """The next multiple or part of the other rate: 1000 / 27.18 is 36.8. With a rate of the graph, and without."""
    rates = {"first": "1 kHz", "second": far}
    (problem,) = refused(rates, rate)
    assert problem.path == ("blocks", "second", "rate")
    named = re.fullmatch(r"make the rates ratios of small numbers: (.*) for second, for example", problem.hint)
    assert named is not None
    assert named[1] == near
    assert refused(rates | {"second": named[1]}, rate) == []
