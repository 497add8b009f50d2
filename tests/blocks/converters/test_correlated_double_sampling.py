"""Differences of two samples of a window, by slices of an array."""

import numpy as np
import pytest

from proofmass.blocks import CorrelatedDoubleSampling
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, response


@pytest.mark.parametrize(("window", "first", "second"), [(2, 0, 1), (8, 1, 6), (5, 3, 4)])
def test_against_slices(window: int, first: int, second: int) -> None:
    u = np.array(noise(40 * window))
    block = CorrelatedDoubleSampling(window=window, first=first, second=second)
    answer = response(block, u.tolist(), "difference")[::window]
    assert answer == [0.0, *(u[second::window] - u[first::window])[:-1]]


@pytest.mark.derivation(
    CorrelatedDoubleSampling,
    equation="output = u at place second - u at place first, once in a window",
    source="textbook: 2 sin(pi f gap) of a sine, by its rms over 10,000 windows",
    convention="signal less reset; given at the window's rate; gain of amplitudes, twice as much power of white noise",
)
def test_its_gain_at_a_frequency_is_that_of_the_textbook() -> None:
    """2 sin(pi f gap) for a gap between the samples."""
    carrier = np.sin(2.0 * np.pi * 0.011 * np.arange(40_000))
    answer = np.array(response(CorrelatedDoubleSampling(window=4, first=0, second=3), carrier, "difference")[4::4])
    assert np.sqrt(2.0 * np.mean(answer**2)) == pytest.approx(2.0 * np.sin(np.pi * 0.011 * 3), rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "text"), [({"first": 1}, "less than second = 1"), ({"second": 2}, "less than window = 2")]
)
def test_places_outside_the_window_are_refused(changes: dict[str, int], text: str) -> None:
    with pytest.raises(ModelError, match=text):
        CorrelatedDoubleSampling(**changes)


def test_white_noise_comes_with_twice_its_power() -> None:
    answer = np.array(response(CorrelatedDoubleSampling(window=4, first=1, second=2), noise(40_000), "difference"))
    assert np.var(answer[4::4]) == pytest.approx(2.0, rel=0.04)
