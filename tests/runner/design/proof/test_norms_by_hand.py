"""Norms, discs and half planes of small matrices, worked out by hand."""

import math
from typing import Any

import flint
import numpy as np
import pytest

from proofmass.runner.derivatives.ball import Ball, UndecidedError
from proofmass.runner.derivatives.taylor_model import TaylorModel
from proofmass.runner.design.proof import contraction
from proofmass.runner.design.proof.closed_loop import Disc, Family, OpenCorners, closed_loops, through, with_disk
from proofmass.runner.design.proof.contraction import (
    Norm,
    bound_of,
    covariance_norm,
    first_norm,
    growth_of,
    outer_corner,
    radius_of,
)
from proofmass.runner.design.proof.enclosed import UNIT, Enclosed
from proofmass.runner.design.proof.half_plane import HalfPlane
from proofmass.runner.design.proof.wire_factors import GAIN, PHASE


def exact(*matrices: Any) -> Enclosed:
    middle = np.array(matrices, dtype=float)
    return Enclosed(middle, np.zeros_like(middle))


def family(*matrices: Any, factors: int = 1, **more: Any) -> Family:
    return Family(exact(*matrices), factors, more.pop("shares", {}), **more)


def contracts(*matrices: Any, transform: Any = None, **more: Any) -> bool:
    of = family(*matrices, **more)
    return Norm(np.eye(of.centre.shape[0]) if transform is None else np.array(transform, dtype=float), of).contracts()


# -- enclosed matrices -------------------------------------------------------------------------------------------------


def test_balls_are_enclosed_tightly() -> None:
    found = Enclosed.of_balls([[[0.1, Ball(flint.arb(2, 0.25))]]])
    assert found.middle.tolist() == [[[0.1, 2.0]]]
    assert found.radius[0, 0] == pytest.approx([0.0, 0.25], rel=1e-8)
    assert found.radius[0, 0, 1] >= 0.25
    with pytest.raises(UndecidedError, match="without bounds"):
        Enclosed.of_balls([[[Ball(flint.arb(0, math.inf))]]])


def test_stacks_of_enclosed_matrices() -> None:
    one, other = exact([[1.0]], [[2.0]]), Enclosed(np.array([[[3.0]], [[4.0]]]), np.full((2, 1, 1), 0.5))
    assert Enclosed.stacked([one, other]).middle.ravel().tolist() == [1.0, 2.0, 3.0, 4.0]
    assert Enclosed.interleaved([one, other]).middle.ravel().tolist() == [1.0, 3.0, 2.0, 4.0]
    assert Enclosed.interleaved([one, other]).radius.ravel().tolist() == [0.0, 0.5, 0.0, 0.5]
    joined = Enclosed.joined([[one, other], [other, one]])
    assert joined.middle.tolist() == [[[1.0, 3.0], [3.0, 1.0]], [[2.0, 4.0], [4.0, 2.0]]]
    assert joined.radius[0].tolist() == [[0.0, 0.5], [0.5, 0.0]]
    table = exact([[1.0, 2.0], [3.0, 4.0]])
    assert table.repeated(2).middle[0].tolist() == [[1, 2, 0, 0], [3, 4, 0, 0], [0, 0, 1, 2], [0, 0, 3, 4]]
    assert table.spread(2).middle[0].tolist() == [[1, 0, 2, 0], [0, 1, 0, 2], [3, 0, 4, 0], [0, 3, 0, 4]]
    assert table[slice(1), slice(1, 2)].middle.tolist() == [[[2.0]]]


def test_sums_and_products_with_their_errors() -> None:
    """(2 +- 0.5) (3 +- 0.25) is within 6 +- (2 * 0.25 + 3 * 0.5 + 0.125), and more by rounding only."""
    two, three = (Enclosed(np.array([[[x]]]), np.array([[[r]]])) for x, r in ((2.0, 0.5), (-3.0, 0.25)))
    made = two @ three
    assert made.middle.item() == -6.0
    assert 2.125 < made.radius.item() < 2.125 + 100.0 * UNIT + 1e-11
    added = two + three
    assert added.middle.item() == -1.0
    assert 0.75 < added.radius.item() < 0.75 * (1.0 + 1e-11)
    moved = two.moved(np.array([[1.0]]))
    assert (moved.middle.item(), moved.radius.item()) == (3.0, pytest.approx(0.5))
    times = three.scaled(-2.0)
    assert (times.middle.item(), times.radius.item()) == (6.0, pytest.approx(0.5))
    assert times.radius.item() > 0.5
    exactly = exact([[1.0, 2.0]]) @ exact([[3.0], [4.0]])
    assert 11.0 * 2.0 * UNIT <= exactly.radius.item() <= 11.0 * 5.0 * UNIT


# -- families ----------------------------------------------------------------------------------------------------------


def test_moves_of_coordinates_and_of_the_factor() -> None:
    """m + 2 i + 3 j + 5 f at the ends of i, j and f."""
    corners = [[[10.0 + 2.0 * i + 3.0 * j + 5.0 * f]] for i in (-1, 1) for j in (-1, 1) for f in (-1, 1)]
    assert family(*corners, factors=2).moves().ravel().tolist() == [2.0, 3.0, 5.0]
    assert family([[1.0]]).moves().shape == (0, 1, 1)
    assert family([[1.0]], [[3.0]], factors=2).moves().ravel().tolist() == [1.0]
    assert family([[1.0]], [[3.0]]).centre.tolist() == [[2.0]]


def test_parts_of_matrices_side_by_side() -> None:
    whole = family(np.diag([1.0, 2.0, 3.0]), shares={4: np.diag([0.1, 0.2, 0.3])}, blocks=(1, 2))
    one, two = whole.parts()
    assert one.corners.middle.tolist() == [[[1.0]]]
    assert two.corners.middle[0].tolist() == [[2.0, 0.0], [0.0, 3.0]]
    assert two.shares[4].tolist() == [[0.2, 0.0], [0.0, 0.3]]
    assert (one.blocks, two.blocks) == ((), ())


def test_a_disc_is_moved_to_zero_and_made_one() -> None:
    given = family([[1.5]], shares={0: np.array([[0.25]])})
    moved = Disc(0.5, 0.0, 2.0).moved(given, 1)
    assert moved.corners.middle.item() == 0.5
    assert moved.shares[0].item() == pytest.approx(0.125)
    assert moved.shares[0].item() > 0.125
    assert Disc(0.0, 0.0, 1.0).moved(given, 1) is given
    complex_one = Disc(0.5, 0.25, 0.5).moved(family([[1.0, 0.0], [0.0, 1.0]]), 2)
    assert complex_one.corners.middle[0].tolist() == [[1.0, 0.5], [-0.5, 1.0]]
    assert Disc(0.5, 0.0, 2.0).beyond(moved).item() == pytest.approx(0.25)
    assert [Disc(0.0, 0.0, radius).empty for radius in (-1.0, 0.0, 1e-9)] == [True, True, False]
    assert Disc(1.0, 2.0, 3.0).as_data() == {"disc": [1.0, 2.0, 3.0]}


def opened(a: Any, b: Any, c: Any, d: Any) -> OpenCorners:
    """One corner, which nothing moves."""
    matrix = np.block([[np.array(a), np.array(b)], [np.array(c), np.array(d)]])
    terms = tuple(TaylorModel.constant(part) for part in (a, b, c, d))
    return OpenCorners(len(a), len(d), exact(matrix), lambda: terms, None, (), 0)  # type: ignore[arg-type]


TWO = opened([[0.5]], [[2.0, 3.0]], [[5.0], [7.0]], [[0.0, 0.0], [11.0, 0.0]])


def test_loops_closed_with_a_gain() -> None:
    """Two values of the wire: A + B F (1 + D F) C = 0.5 + g (2 * 5 + 3 * 7) + g^2 3 * 11 * 5."""
    found = closed_loops(GAIN, TWO, (0.5, 2.0))
    assert found.factors == 2
    assert found.sensors is not None
    assert found.sensors.ravel().tolist() == [0.5 + 15.5 + 41.25, 0.5 + 62.0 + 660.0, 0.5 + 38.75 + 1.5625 * 165.0]
    assert (closed_loops(GAIN, TWO, (2.0, 2.0)).factors, found.still) == (1, 0)


def test_loops_closed_with_a_phase_lie_in_a_triangle() -> None:
    """0.5 + 6 e^jp from 0 to a sixth of a turn; the tangents cross at 1 / cos(30 deg), half way."""
    found = closed_loops(PHASE, opened([[0.5]], [[2.0]], [[3.0]], [[0.0]]), (0.0, math.pi / 3.0))
    points = [complex(m[0, 0], m[1, 0]) for m in found.corners.middle]
    turned = [1.0, np.exp(1j * math.pi / 3.0), np.exp(1j * math.pi / 6.0) / math.cos(math.pi / 6.0)]
    assert points == pytest.approx([0.5 + 6.0 * turn for turn in turned])
    assert found.factors == 3


def test_all_factors_of_a_disk_are_one_matrix() -> None:
    """E = [[1, 0], [11, 1]], so B E = [35, 3] and E C = [5, 62]."""
    found = with_disk(TWO, (0.25, 0.25))
    assert found.corners.middle[0] == pytest.approx(
        np.array([[0.5 + 35.0 * 5.0 + 3.0 * 7.0, 35.0, 3.0], [1.25, 0.125, 0.0], [15.5, 2.75, 0.125]])
    )
    assert (found.still, found.factors) == (2, 1)


def test_a_response_is_divided_by_its_limit() -> None:
    found = through(TWO, (4.0, 4.0))
    assert found.corners.middle[0] == pytest.approx(np.array([[0.5, 2.0, 3.0], [1.25, 0.0, 0.0], [1.75, 2.75, 0.0]]))
    assert found.still == 2


# -- norms -------------------------------------------------------------------------------------------------------------


def test_a_matrix_contracts_if_its_norm_is_below_one() -> None:
    assert contracts([[1.0 - 1e-12]])
    assert not contracts([[1.0]])
    assert not contracts([[0.5]], [[1.0]]), "each corner counts"
    skew = [[0.5, 8.0], [0.0, 0.5]]
    assert not contracts(skew)
    assert contracts(skew, transform=[[32.0, 0.0], [0.0, 1.0]])
    assert contracts([[0.75]], shares={0: np.array([[0.125]]), 1: np.array([[0.124]])})
    assert not contracts([[0.75]], shares={0: np.array([[0.125]]), 1: np.array([[0.126]])})


def test_what_a_coordinate_bends_counts_with_its_norm() -> None:
    """A rotation has two equal singular values, of which the bound is 2^(1 / 16) too large; a line has one."""
    rotation = 0.2 * np.array([[0.6, -0.8], [0.8, 0.6]])
    of = family(0.75 * np.eye(2), bends={3: np.array([rotation, 0.25 * rotation])}, shares={3: 0.01 * np.eye(2)})
    norm = Norm(np.diag([4.0, 4.0]), of)
    assert norm.bent == {3: pytest.approx(0.25, rel=2.0 ** (1 / 16) - 1.0 + 2e-6)}
    assert norm.bent[3] >= 0.25
    assert norm.bend >= norm.bent[3]
    assert norm.shares == {3: pytest.approx(norm.bent[3] + 0.01 * math.sqrt(2.0))}
    assert norm.beyond == pytest.approx(norm.bent[3] + 0.01)
    line = np.array([[[0.0, 0.2], [0.0, 0.0]]])
    assert contracts(np.zeros((2, 2)), bends={0: line * 4.9})
    assert not contracts(np.zeros((2, 2)), bends={0: line * 5.01})
    assert contracts(np.zeros((2, 2)), bends={0: line * 9.9}, transform=[[2.0, 0.0], [0.0, 1.0]])


def test_the_slopes_of_what_bends() -> None:
    draw = np.random.default_rng(4)
    matrices, step = draw.normal(size=(3, 4, 4)), np.eye(4) + 0.1 * draw.normal(size=(4, 4))

    def size(of: Any) -> float:
        return sum(float(np.linalg.norm(np.linalg.inv(of) @ matrix @ of)) for matrix in matrices)

    value, slopes = contraction._bends(np.linalg.inv(step), matrices, step)
    assert value == pytest.approx(size(step))
    for place in np.ndindex(4, 4):
        moved = np.zeros((4, 4))
        moved[place] = 1e-5
        assert slopes[place] == pytest.approx((size(step + moved) - size(step - moved)) / 2e-5, rel=1e-5, abs=1e-7)


def test_noise_that_enters_keeps_its_limit_too() -> None:
    """Rows of 3 and 4 beside what may be 1 more each: sqrt(16 + 25) in units of 2."""
    noise = exact([[6.0], [8.0]])
    more: Any = {"noise": noise, "beyond_noise": np.array([[2.0], [2.0]])}
    zero, double = np.zeros((2, 2)), 2.0 * np.eye(2)
    size = math.sqrt(41.0)
    assert Norm(double, family(zero, **more)).rms == pytest.approx(size)
    assert contracts(zero, transform=double, limit=size * (1.0 + 1e-9), **more)
    assert not contracts(zero, transform=double, limit=size * (1.0 - 1e-9), **more)
    assert Norm(double, family(zero)).rms == 0.0


def test_matrices_side_by_side_contract_alone() -> None:
    """Their norm together would count what lies between them."""
    beside = [[0.5, 9.0], [0.0, 0.5]]
    assert contracts(beside, blocks=(1, 1))
    assert not contracts([[0.5, 0.0], [0.0, 1.5]], blocks=(1, 1))
    assert not contracts([[1.5, 0.0], [0.0, 0.5]], blocks=(1, 1))
    sized = Norm(np.diag([2.0, 3.0, 4.0]), family(np.eye(3), blocks=(1, 0, 2))).parts()
    assert [part.transform.tolist() for part in sized] == [[[2.0]], [[3.0, 0.0], [0.0, 4.0]]]


def test_sizes_in_the_coordinates_of_a_transformation() -> None:
    of = Norm(np.diag([2.0, 0.5]), family([[0.0, 1.0], [0.0, 0.0]], [[0.0, 3.0], [0.0, 0.0]], shares={7: np.eye(2)}))
    assert of.worst() == pytest.approx(0.75)
    assert of.moves() == pytest.approx([0.25])
    assert of.shares == {7: pytest.approx(math.sqrt(2.0))}
    assert of.rest == pytest.approx(np.eye(2))


def test_the_least_disc_of_a_norm() -> None:
    norm, disc = Norm(np.eye(1), family([[0.5]])).tightened(Disc(0.0, 0.0, 0.5), 1)
    assert 0.25 < disc.radius < 0.2501
    assert norm.contracts()
    lost = Norm(np.eye(1), family([[1.5]]))
    assert lost.tightened(Disc(0.0, 0.0, 0.5), 1) == (lost, Disc(0.0, 0.0, 0.5))


def test_growth_from_one_norm_to_another() -> None:
    """|T^-1 x|: what has size one in the norm of 3 is 3, and 12 in the norm of 1 / 4."""
    grown = growth_of(np.diag([3.0, 1.0]), np.diag([0.25, 1.0]))
    assert 12.0 <= grown < 12.0 * (1.0 + 1e-9)


@pytest.mark.defect("H842", before="a growth of 1e155 was looked for without end", after="taken as without bound")
def test_a_growth_whose_square_is_no_number_has_no_bound() -> None:
    assert growth_of(np.eye(1), np.array([[1e-155]])) == math.inf
    assert growth_of(np.eye(1), np.array([[1e-150]])) == pytest.approx(1e150)


def test_the_corner_beyond_the_disc() -> None:
    """Of three factors the last is the crossing of tangents, and none of the claim."""
    corners = [[[0.5]], [[0.6]], [[9.0]], [[-1.5]], [[1.2]], [[0.1]]]
    assert outer_corner(family(*corners, factors=3)) == 1
    assert outer_corner(family(*corners[:3], factors=3)) is None
    assert outer_corner(family([[1.0 + 1e-13]], [[0.5]], factors=2)) is None
    assert outer_corner(family([[1.0 + 1e-11]], [[0.5]], factors=2)) == 0
    assert outer_corner(family(*corners, factors=3, still=1)) is None
    assert outer_corner(family(*corners, factors=3, blocks=(1,))) is None
    assert radius_of(family([[0.0, 2.0], [-2.0, 0.0]])) == pytest.approx(2.0)
    assert radius_of(family(np.zeros((0, 0)))) == 0.0


def test_a_bound_of_all_matrices_of_some_sizes() -> None:
    """Rows add up to 3 and 7, columns to 4 and 6."""
    assert bound_of(np.array([[1.0, 2.0], [3.0, 4.0]])) == pytest.approx(math.sqrt(42.0))


@pytest.mark.parametrize(
    ("rate", "falls"),
    [
        ([[-1.0]], True),
        ([[-1e-9]], True),
        ([[0.0]], False),
        ([[1.0]], False),
        ([[-1.0, 1.99], [0.0, -1.0]], True),
        ([[-1.0, 2.01], [0.0, -1.0]], False),
        ([[0.0, 1.0], [-1.0, 0.0]], False),
        ([[math.nan]], False),
    ],
)
def test_rates_that_shorten_every_vector(rate: Any, falls: bool) -> None:
    assert contraction._decay(np.eye(len(rate)), family(rate)) is falls


def test_rates_with_an_input_and_an_output() -> None:
    """x' = -x + u, y = c x: its gain c at rest is below one for c < 1, in the norm in which both are the same."""
    for c, falls in ((0.99, True), (1.01, False)):
        rates = family([[-1.0, 1.0], [c, 0.0]], still=1)
        assert contraction._decay(np.array([[1.0, 0.0], [0.0, 1.0]]), rates) is falls
    for share, falls in ((0.99, True), (1.01, False)):
        assert contraction._decay(np.eye(1), family([[-1.0]], shares={0: np.array([[share]])})) is falls


def test_a_solution_of_riccatis_equation() -> None:
    """P = A'PA + C'C + e + (A'PB + C'D) (1 - D'D - B'PB)^-1 (B'PA + D'C), the smaller of both."""
    a, b, c, d = (
        np.array([[0.5, 0.1], [0.0, 0.3]]),
        np.array([[0.2], [0.1]]),
        np.array([[0.3, 0.4]]),
        np.array([[0.25]]),
    )
    p = contraction._riccati(a, b, c, d, 0.01)
    mixed = a.T @ p @ b + c.T @ d
    right = a.T @ p @ a + c.T @ c + 0.01 * np.eye(2) + mixed @ np.linalg.inv(1.0 - d.T @ d - b.T @ p @ b) @ mixed.T
    np.testing.assert_allclose(p, right, rtol=1e-12)
    assert (np.linalg.eigvalsh(p) > 0.0).all()
    closed = a + b @ np.linalg.inv(1.0 - d.T @ d - b.T @ p @ b) @ mixed.T
    assert np.abs(np.linalg.eigvals(closed)).max() < 1.0, "the solution that leaves all stable"


def test_norms_that_are_found() -> None:
    """Of a skew matrix that decays, and of one with an input and an output of a gain below one."""
    skew = family([[0.9, 50.0], [0.0, 0.9]])
    found = first_norm(skew)
    assert found is not None
    assert found.contracts()
    assert found.improved().worst() < found.worst()
    assert first_norm(family([[1.0, 0.0], [0.0, 0.5]])) is None
    for gain, there in ((0.95, True), (1.05, False)):
        disk = first_norm(family([[0.5, 1.0], [0.5 * gain, 0.0]], still=1))
        assert (disk is not None and disk.contracts()) is there
    assert first_norm(family([[1.5, 1.0], [0.1, 0.0]], still=1)) is None
    only = first_norm(family([[0.5]], still=1))
    assert only is not None
    assert only.transform.tolist() == [[1.0]]


def test_the_norm_of_a_covariance() -> None:
    """Noise that counts alike in all directions makes W = A W A' + Q: here T T' is W, but for its size."""
    a = np.array([[0.5, 0.25], [0.0, 0.75]])
    t = covariance_norm(family(a), a, 1.0, 1.0).transform
    w = t @ t.T
    left = w - a @ w @ a.T
    assert left[0, 1] == pytest.approx(0.0, abs=1e-12)
    assert left[0, 0] > 0.0
    assert left[1, 1] > 0.0


# -- half planes -------------------------------------------------------------------------------------------------------


def test_half_planes_are_moved_and_sampled() -> None:
    """-1 and -3 with h = 0.7 / sqrt 3 of their mean speed become (1 + h s) / (1 - h s)."""
    moved = HalfPlane().moved(family(np.diag([-1.0, -3.0])), 1)
    h = 0.7 / math.sqrt(3.0)
    assert moved.corners.middle[0] == pytest.approx(np.diag([(1.0 - h) / (1.0 + h), (1.0 - 3.0 * h) / (1.0 + 3.0 * h)]))
    assert moved.rates is not None
    shifted = HalfPlane(real=-0.5).moved(family(np.diag([-1.0, -3.0])), 1)
    assert shifted.rates is not None
    assert shifted.rates.corners.middle[0] == pytest.approx(np.diag([-0.5, -2.5]))


def test_a_tilted_half_plane_of_complex_poles() -> None:
    """(1 + j r) (s - c) of s = -2 + 0 j, c = -1 + 0.5 j and r = 0.25, as real and imaginary part."""
    plane = HalfPlane(-1.0, 0.5, 0.25)
    share = np.array([[0.125, 0.0], [0.0, 0.0]])
    rates = plane.moved(family(-2.0 * np.eye(2), shares={3: share}), 2).rates
    assert rates is not None
    assert rates.shares[3] == pytest.approx(np.array([[0.125, 0.0], [0.03125, 0.0]]))
    assert (rates.shares[3][:, 0] > [0.125, 0.03125]).all()
    found = (1.0 + 0.25j) * (-2.0 - (-1.0 + 0.5j))
    assert rates.corners.middle[0] == pytest.approx(np.array([[found.real, -found.imag], [found.imag, found.real]]))
    assert plane.as_data() == {"half_plane": [-1.0, 0.5, 0.25]}
    assert (plane.empty, plane.radius) == (False, math.inf)


def test_all_that_goes_through_a_sampled_loop_is_kept() -> None:
    """x' = -2 x + 3 u, y = 5 x + 7 u: at rest y / u is 14.5 before and after, and so is the share at rest."""
    shares = {0: np.array([[0.1, 0.0], [0.0, 0.0]])}
    moved = HalfPlane().moved(family([[-2.0, 3.0], [5.0, 7.0]], still=1, shares=shares), 1)
    ((a, b), (c, d)) = moved.corners.middle[0]
    assert d + c * b / (1.0 - a) == pytest.approx(7.0 + 5.0 * 3.0 / 2.0)
    h = 0.7 / 2.0
    assert a == pytest.approx((1.0 - 2.0 * h) / (1.0 + 2.0 * h))
    # moving A by e moves (1 - h A)^-1 by h e (1 - h A)^-2 = 0.35 e / 1.7^2
    between = 1.0 / (1.0 + 2.0 * h)
    assert moved.shares[0][0, 0] == pytest.approx(0.1 * 2.0 * h * between**2)
    assert HalfPlane().beyond(moved).ravel() == pytest.approx([0.1, 0.0, 0.0, 0.0])
