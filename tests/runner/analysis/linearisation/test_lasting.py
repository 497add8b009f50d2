"""Modes that do not decay, and the system without them."""

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.covariance import alike, summed
from proofmass.runner.analysis.linearisation.lasting import Lasting, _invariant


@pytest.mark.parametrize("second", [1.0, 1.0 - 3e-13, 0.999, 0.9])
def test_two_modes_that_rounding_may_part(second: float) -> None:
    """Two neutral modes last together, however rounding moves them; what is left is the decaying part."""
    random = np.random.default_rng(3)
    poles = np.array([1.0, second, 0.5, 0.1])
    basis = random.normal(size=(4, 4))
    a = basis @ np.diag(poles) @ np.linalg.inv(basis)
    left, right = Lasting(a).reduction
    decaying = poles[poles < 1.0 - 1e-12]
    assert left.shape == (len(decaying), 4)
    assert np.sort(np.linalg.eigvals(left @ a @ right).real) == pytest.approx(np.sort(decaying), abs=1e-9)


def test_the_trim_of_a_gyroscope_at_rest() -> None:
    """A ramp and a trim that nothing drives: their subspaces, looked for apart, were of unlike size."""
    a = np.array([
        [7.6125789510323618e-08, 1.0100526738946347, 1.7126755506377146e-04, 9.3814507938302858e-06,
         1.0074571806799023e-04, -3.5949561437181310e-01],
        [4.7047068645273239e-08, 9.9999053919667280e-01, 1.6956138938253282e-04, 9.3195078602018857e-06,
         9.9742090335007861e-05, -2.2217461500409735e-01],
        [-2.7746517477375023e-04, -3.0615294751303850e-03, -5.1912210272594869e-07, 3.3084957330112162e-03,
         -2.7052637059797772e-07, 1.3102980360151930e+03],
        [7.6125833558420122e-08, 1.0100531928254206, 1.7126764305522890e-04, 8.8676895459210080e-06,
         1.0074576404372000e-04, -3.5949579914897190e-01],
        [7.8252109956210812e-09, 9.2188441741891544e-02, 1.5631748155288870e-05, -9.1270069522344316e-02,
         8.1676227402335578e-06, -3.2825959656975101e-02],
        [-2.1175728025381506e-07, -2.4127045375228865e-08, -4.0910540401768957e-12, 2.3564397231990610e-07,
         -1.5910917026909462e-12, 1.0000000085869332],
    ])  # fmt: skip
    left, right = Lasting(a).reduction
    assert np.max(np.abs(np.linalg.eigvals(left @ a @ right))) < 1e-4


def test_bases_to_the_right_and_to_the_left_belong_together() -> None:
    """W V = 1, A V = V T and W A = T W, with T the part of the matrix that lasts."""
    basis = np.random.default_rng(5).normal(size=(5, 5))
    a = basis @ np.diag([1.0, 0.995, 0.6, 0.3, -0.2]) @ np.linalg.inv(basis)
    right, left = _invariant(a, 0.9)
    assert right.shape == left.shape == (5, 2)
    part = left.T @ a @ right
    assert left.T @ right == pytest.approx(np.eye(2), abs=1e-12)
    assert a @ right == pytest.approx(right @ part, abs=1e-12)
    assert left.T @ a == pytest.approx(part @ left.T, abs=1e-11)
    assert np.sort(np.linalg.eigvals(part).real) == pytest.approx([0.995, 1.0], abs=1e-12)


def test_units_balance_states_but_not_by_what_is_less_than_rounding() -> None:
    """Two states that turn into each other, in units far apart, and a third that they reach with 1e-40."""
    units = np.array([1.0, 2.0**40, 1.0])
    a = np.array([[0.5, 0.3, 0.2], [-0.3, 0.5, 0.1], [1e-40, 0.0, 0.4]]) * units[:, None] / units
    found, _ = alike(a, np.diag(units))
    assert np.abs(found[:2]).max() < 1.0
    assert np.abs(found[0, 2]) > 0.1, "the third has about the unit of the others"


@pytest.mark.defect("S864", before="a mean square of 4.6, or 1e103", after="2.818 of what does not wander")
def test_what_is_gone_after_a_period_has_the_size_of_what_enters() -> None:
    """A alone would say a unit of 1e-122. The mean square is the sum over k of |c A^k|^2, which ends at k = 1."""
    gone = 1e-122
    a = np.array([[gone, 2.5, 1e-150], [0.0, gone, 0.06], [0.0, 0.0, 1.0]])
    c = np.array([[0.5, -1.0, -0.015]])  # the walk, [0.15, 0.06, 1], does not show
    left, right = Lasting(a, np.eye(3)).reduction
    square = c @ right @ summed(left @ a @ right, left @ left.T) @ (c @ right).T
    assert square[0, 0] == pytest.approx(0.25 + 1.0 + 0.015**2 + 1.25**2 + 0.075**2, rel=1e-12)


@pytest.mark.parametrize("coupled", [0.0, 1.0])
def test_an_input_passes_where_modes_that_last_lead_to_the_output(coupled: float) -> None:
    """Two integrators, in a row or side by side, and a lag."""
    lasting = Lasting(np.array([[1.0, 0.0, 0.0], [coupled, 1.0, 0.0], [0.0, 0.0, 0.5]]))
    first, second, lag = np.eye(3)
    assert lasting.passes(first[:, None], second) == bool(coupled)
    assert lasting.passes(first[:, None], first)
    assert not lasting.passes(lag[:, None], second)
