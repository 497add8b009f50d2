"""Notes on frequencies that a rate cannot hold: of sources, filters and meters, not of blocks in continuous time."""

from typing import Any

import pytest

from proofmass.blocks import AllPass, BandMeter, Butterworth, LowPass, Notch, Sine, ToneMeter
from proofmass.graphs.checks.check import check
from proofmass.graphs.model.build import Graph


def noted(block: Any) -> list[str]:
    """Return what is noted of the frequencies of a block at 1 kHz."""
    graph = Graph(name="", rate="1 kHz", duration="1 s", blocks={"source": Sine(), "it": block}, wires=[*_wires(block)])
    return [problem.message for problem in check(graph) if "half the rate" in problem.message]


def _wires(block: Any) -> list[str]:
    return [f"source.output -> it.{name}" for name in type(block).inputs]


@pytest.mark.defect(
    "S876", before="a notch of 600 Hz at 1 kHz was one of 400 Hz, an all-pass there unstable, unsaid", after="a note"
)
@pytest.mark.parametrize(
    ("block", "parameters"),
    [
        (Notch(frequency=600.0), ["frequency"]),
        (AllPass(frequency=500.0), ["frequency"]),
        (AllPass(frequency=499.0), []),
        (Butterworth(corner_frequency=600.0), ["corner_frequency"]),
        (ToneMeter(frequency=1600.0), ["frequency"]),
        (BandMeter(low=10.0, high=400.0), []),
        (LowPass(corner_frequency=600.0), []),  # in continuous time
    ],
)
def test_a_frequency_that_a_sampled_signal_does_not_have_is_noted(block: Any, parameters: list[str]) -> None:
    said = "is not below half the rate: a sampled signal has none there"
    assert noted(block) == [f"the {parameter} {said}" for parameter in parameters]


def test_a_source_that_is_too_fast_has_the_values_of_a_slower_one() -> None:
    said = "the frequency is not below half the rate: the values are those of a lower one"
    assert noted(Sine(frequency=600.0)) == [said]
