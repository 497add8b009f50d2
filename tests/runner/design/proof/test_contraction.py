"""What a norm allows the corners to have, less what rounding may hide."""

import numpy as np

from proofmass.runner.design.proof.closed_loop import Family
from proofmass.runner.design.proof.contraction import Norm
from proofmass.runner.design.proof.enclosed import UNIT, Enclosed


def test_room_is_left_for_the_rounding_of_a_transformation_and_its_inverse() -> None:
    """Each entry of the product of n x n matrices is off by up to n units of |X| |T| (Higham 2002, 3.13)."""
    transform = np.eye(4)
    transform[0, 1] = 1e8
    corners = Enclosed(np.zeros((1, 4, 4)), np.zeros((1, 4, 4)))
    room = Norm(transform, Family(corners, 1, {})).room
    entries = np.abs(np.linalg.inv(transform)) @ np.abs(transform)
    assert 4.0 * UNIT * entries.max() <= 1.0 - room < 100.0 * UNIT * entries.max()


def test_what_coordinates_add_takes_their_norm_from_the_room() -> None:
    """Within 0.25 of the corners in every entry of two: a spectral norm of up to 0.5."""
    corners = Enclosed(0.25 * np.eye(2)[None], np.zeros((1, 2, 2)))
    assert abs(Norm(np.eye(2), Family(corners, 1, {0: np.full((2, 2), 0.25)})).room - 0.5) < 1e-9
    assert Norm(np.eye(2), Family(corners, 1, {0: np.full((2, 2), 0.25)})).contracts()
    assert not Norm(np.eye(2), Family(corners, 1, {0: np.full((2, 2), 0.4)})).contracts()
