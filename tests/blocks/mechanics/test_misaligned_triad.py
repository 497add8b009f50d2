"""The triad against a matrix, and small errors as a rotation."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from proofmass.blocks import MisalignedTriad
from tests.by_hand.functions import drive

NAMES = ("scale_x", "xy", "xz", "yx", "scale_y", "yz", "zx", "zy", "scale_z")


def sensed(errors: np.ndarray, true: np.ndarray) -> list[float]:
    block = MisalignedTriad(**dict(zip(NAMES, errors.ravel().tolist(), strict=True)))
    (row,) = drive(block, [dict(zip(("true_x", "true_y", "true_z"), true.tolist(), strict=True))])
    return [row["sensed_x"], row["sensed_y"], row["sensed_z"]]


def test_against_a_matrix() -> None:
    dice = np.random.default_rng(1)
    errors, true = 0.01 * dice.normal(size=(3, 3)), dice.normal(size=3)
    assert sensed(errors, true) == pytest.approx((np.eye(3) + errors) @ true, rel=1e-14)


def test_a_small_rotation_of_the_block() -> None:
    turned = Rotation.from_rotvec([1e-4, -2e-4, 3e-4]).as_matrix().T
    true = np.array([1.0, 2.0, -9.81])
    assert sensed(turned - np.eye(3), true) == pytest.approx(turned @ true, rel=1e-13)


@pytest.mark.derivation(
    MisalignedTriad,
    equation="x = (1 + sx) X + mxy Y + mxz Z, and so on",
    source="dot products with unit vectors that lean, by cosines and sines of whole angles",
    convention="mxy is how far axis x leans to Y, not Y to x; in rad, of first order; the scale is not in the angles",
)
def test_axes_that_lean() -> None:
    """An axis that leans to another by an angle feels its sine: that of 2 mrad is off by 2e-6 of the whole."""
    lean, scale, true = 2e-3, 5e-3, np.array([0.0, 7.0, 0.0])
    axes = np.eye(3)
    axes[0] = [math.cos(lean), math.sin(lean), 0.0]
    axes[2] = [0.0, -math.sin(3.0 * lean), math.cos(3.0 * lean)]
    expected = axes @ true + [0.0, scale * 7.0, 0.0]
    errors = np.array([[0.0, lean, 0.0], [0.0, scale, 0.0], [0.0, -3.0 * lean, 0.0]])
    assert sensed(errors, true) == pytest.approx(expected, rel=1e-5, abs=1e-12)
    up = axes @ [1.0, 0.0, 0.0]
    assert sensed(errors, np.array([1.0, 0.0, 0.0])) == pytest.approx(up, abs=lean**2)
