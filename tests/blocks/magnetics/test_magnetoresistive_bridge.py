"""The bridge against Kirchhoff's laws for four resistors."""

import math

import numpy as np
import pytest

from proofmass.blocks import MagnetoresistiveBridge
from tests.by_hand.responses import responses


def test_against_four_resistors() -> None:
    block = MagnetoresistiveBridge(ratio=0.3, saturation=4e-3)
    fields = [-20e-3, -1e-3, 0.0, 4e-3, 1.0]
    expected = []
    for field in fields:
        turned = math.sin(math.atan(field / 4e-3))  # of the free layer
        more, less = 1.0 / (1.0 + 0.3 * turned), 1.0 / (1.0 - 0.3 * turned)
        left, right = 3.0 * less / (more + less), 3.0 * more / (more + less)  # of 3 V, behind one arm of each half
        expected.append(left - right)
    assert responses(block, "voltage", field=fields, supply=[3.0] * 5) == pytest.approx(expected, abs=1e-14)


def test_slope_and_imbalance() -> None:
    block = MagnetoresistiveBridge(imbalance=1e-3)
    low, zero, high = responses(block, "voltage", field=[-1e-7, 0.0, 1e-7], supply=[2.0] * 3)
    assert zero == 2e-3
    assert np.divide(high - low, 2e-7) == pytest.approx(2.0 * 0.4 / 5e-3, rel=1e-8)
