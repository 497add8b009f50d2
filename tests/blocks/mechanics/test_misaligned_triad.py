"""The triad against a matrix, and small errors as a rotation."""

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
