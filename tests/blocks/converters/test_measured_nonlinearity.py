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
