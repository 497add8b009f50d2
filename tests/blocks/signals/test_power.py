"""Powers against numpy: whole and broken exponents, odd and even."""

import numpy as np
import pytest

from proofmass.blocks import Power
from tests.by_hand.responses import noise, response


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.7, 2.0, 3.0])
def test_against_numpy(exponent: float) -> None:
    signal = np.array(noise(300))
    block = Power(exponent=exponent, reference=0.5, scale=3.0)
    expected = 3.0 * np.power(np.abs(signal) / 0.5, exponent)
    assert response(block, signal.tolist()) == pytest.approx(expected, rel=1e-13)
    odd = Power(exponent=exponent, reference=0.5, scale=3.0, odd=True)
    assert response(odd, signal.tolist()) == pytest.approx(expected * np.sign(signal), rel=1e-13)


def test_at_the_reference_it_is_the_scale() -> None:
    assert response(Power(exponent=1.5, reference=3.0, scale=-7.0), [3.0, 0.0]) == [-7.0, 0.0]
