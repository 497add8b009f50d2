"""The bridge against Kirchhoff's laws for four resistors."""

import math

import numpy as np
import pytest
from scipy import optimize

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


@pytest.mark.derivation(
    MagnetoresistiveBridge,
    equation="voltage = supply (ratio m + imbalance), m = B / sqrt(B^2 + Bk^2)",
    source="least energy of a free layer in two fields, Slonczewski's conductances at a TMR of 100 %, Kirchhoff's laws",
    convention="ratio is TMR / (2 + TMR), a third here; full bridge, its output from -ratio to ratio of the supply",
    wrong="the documents gave the layer a hard axis along the field, which makes m = B / Bk; TMR was not named",
)
@pytest.mark.parametrize("field", [2e-3, -5e-3])
def test_a_free_layer_of_least_energy_in_four_junctions(field: float) -> None:
    bias, low, tmr, supply = 4e-3, 1000.0, 1.0, 2.5

    def energy(angle: float) -> float:
        return -field * math.sin(angle) - bias * math.cos(angle)

    angle = optimize.minimize_scalar(energy, bounds=(-1.5, 1.5), method="bounded", options={"xatol": 1e-10}).x
    parallel, against = 1.0 / low, 1.0 / (low * (1.0 + tmr))
    mean, swing = 0.5 * (parallel + against), 0.5 * (parallel - against)
    up, down = mean + swing * math.sin(angle), mean - swing * math.sin(angle)  # references along and against the field
    nodes = np.array([[up + down, 0.0], [0.0, up + down]])
    left, right = np.linalg.solve(nodes, [supply * up, supply * down])
    block = MagnetoresistiveBridge(ratio=tmr / (2.0 + tmr), saturation=bias)
    assert responses(block, "voltage", field=[field], supply=[supply]) == pytest.approx([left - right], rel=1e-7)
