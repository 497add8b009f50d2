"""The pulses: duty, number and place of their edges, both carriers."""

import numpy as np
import pytest
from scipy import special

from proofmass.blocks import PulseWidthModulator
from tests.by_hand.responses import response


@pytest.mark.exhaustive(but=3)
@pytest.mark.parametrize("triangular", [False, True])
@pytest.mark.parametrize("value", [-0.8, 0.0, 0.31, 1.0])
def test_the_duty_is_that_of_the_input(triangular: bool, value: float) -> None:
    block = PulseWidthModulator(frequency=1.0, triangular=triangular, low=0.0, high=3.0)
    answer = response(block, [value] * 40_960, period=2.0**-12)
    assert np.mean(answer) == pytest.approx(3.0 * 0.5 * (1.0 + value), abs=3.0 * 2.0 / 4096.0)
    assert np.count_nonzero(np.diff(answer)) == (20 if triangular else 19 if value < 1.0 else 0)


def test_edges_of_a_sawtooth_and_of_a_triangle_by_hand() -> None:
    """Eight ticks a period: carriers -1, -.75 ... .75 and -1, -.5, 0, .5, 1, .5, 0, -.5."""
    saw = response(PulseWidthModulator(frequency=0.125), [0.1] * 8)
    assert saw == [1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0]
    triangle = response(PulseWidthModulator(frequency=0.125, triangular=True), [0.1] * 8)
    assert triangle == [1.0, 1.0, 1.0, -1.0, -1.0, -1.0, 1.0, 1.0]


@pytest.mark.derivation(
    PulseWidthModulator,
    equation="output = high while input > carrier, the carrier from -1 to 1; duty (1 + input) / 2",
    source="double Fourier series of natural sampling, both edges: 4 / (m pi) J_n(m pi M / 2) sin((m + n) pi / 2)",
    convention="lines are peaks; M is the peak of the input; the swing is from low to high, 2 here by halves of it",
)
def test_sidebands_of_natural_sampling_are_bessel_functions() -> None:
    """M = 0.8, 16 carrier periods of 512 ticks in one of the signal (Holmes and Lipo, section 3.3)."""
    ticks, carriers, depth = 512, 16, 0.8
    n = ticks * carriers
    signal = (depth * np.cos(2.0 * np.pi * np.arange(n) / n)).tolist()
    block = PulseWidthModulator(frequency=1.0, triangular=True, low=-3.0, high=3.0)
    lines = 2.0 / n * np.abs(np.fft.rfft(response(block, signal, period=1.0 / ticks)))
    assert lines[1] == pytest.approx(3.0 * depth, rel=2e-3)
    assert lines[2:8].max() < 0.02
    for m, side in ((1, 0), (1, 2), (1, -2), (2, 1), (2, -1), (2, 3)):
        bessel = 4.0 / (m * np.pi) * special.jv(abs(side), m * np.pi * depth / 2.0)
        assert lines[m * carriers + side] == pytest.approx(3.0 * abs(bessel), abs=0.02)
