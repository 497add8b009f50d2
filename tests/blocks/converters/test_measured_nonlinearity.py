"""The table against NumPy's interpolation."""

import numpy as np
import pytest

from proofmass.blocks import MeasuredNonlinearity
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, response


def test_against_interp() -> None:
    errors = (0.5, -1.0, 2.0, 0.0, 0.25)
    volts = [*noise(300, 1, 2.0), -2.5, 2.5, 7.0]
    found = response(MeasuredNonlinearity(bits=12, errors=errors), volts, "output", "voltage")
    expected = np.array(volts) + np.interp(volts, np.linspace(-2.5, 2.5, 5), errors) * 2.5 / 2048.0
    assert found == pytest.approx(expected, rel=1e-13, abs=1e-15)


def test_one_error_is_no_table() -> None:
    with pytest.raises(ModelError, match="two numbers or more"):
        MeasuredNonlinearity(errors=(1.0,))


@pytest.mark.derivation(
    MeasuredNonlinearity,
    equation="output = v + lsb e(v), straight lines between equally spaced errors, lsb = reference / 2^(bits-1)",
    source="Fourier's series of a rectified sine: a tent of height 1 is 1 - |sin|, with 4 / (3 pi) of the second line",
    convention="errors in steps of the span over 2^bits, from -reference to reference; lines are peaks",
)
def test_a_tent_makes_the_lines_of_a_rectified_sine() -> None:
    n, step = 4096, 2.0 * 3.0 / 2**10
    volts = 3.0 * np.sin(2.0 * np.pi * np.arange(n) / n)
    block = MeasuredNonlinearity(bits=10, reference=3.0, errors=(0.0, 5.0, 0.0))
    error = (np.array(response(block, volts.tolist(), "output", "voltage")) - volts) / step
    lines = np.fft.rfft(error) * 2.0 / n
    assert lines[0].real / 2.0 == pytest.approx(5.0 * (1.0 - 2.0 / np.pi), rel=1e-5)
    assert lines[2].real == pytest.approx(5.0 * 4.0 / (3.0 * np.pi), rel=1e-5)
    assert lines[4].real == pytest.approx(5.0 * 4.0 / (15.0 * np.pi), rel=1e-5)
