"""Boxes of tolerances, passages between them, points of rest and descents, worked out by hand."""

import math
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest

from proofmass.runner.derivatives.ball import Ball, UndecidedError
from proofmass.runner.derivatives.polynomial import PolynomialBall
from proofmass.runner.design.proof import box_maps
from proofmass.runner.design.proof.box_maps import BoxMaps, middle_of
from proofmass.runner.design.proof.closed_loop import Disc
from proofmass.runner.design.proof.coordinates import Coordinates, ProvedRegion, widened
from proofmass.runner.design.proof.descent import descended, largest, unknown
from proofmass.runner.design.proof.enclosed import Enclosed, RestPoint, near_inverse
from proofmass.runner.design.proof.passages import _periods, halved_places, too_soon

ONE = (1.0, 1.0)  # the factor at the wire, which stays


def region(core: Any, box: Any, transform: Any = ((1.0,),), radius: float = 0.5) -> Any:
    return ProvedRegion(
        core, box, np.array(transform), np.zeros(0), 0.0, None, None, None, None, Disc(0.0, 0.0, radius)
    )  # type: ignore[arg-type]


# -- sides of a box ----------------------------------------------------------------------------------------------------


def made(low: float, high: float, name: str) -> Any:
    return SimpleNamespace(low=low, high=high, name=name, written=f"{name}!", unit="kg")


def coordinates(*inverse: bool) -> Coordinates:
    ranges = made(2.0, 4.0, "a"), made(-8.0, -4.0, "b"), made(-1.0, 1.0, "c")
    return Coordinates(None, None, ranges, inverse or (False,) * 3)  # type: ignore[arg-type]


def test_a_coordinate_is_a_parameter_or_one_divided_by_it() -> None:
    assert coordinates().box() == ((2.0, 4.0), (-8.0, -4.0), (-1.0, 1.0))
    a, b, c = coordinates(True, True, False).box()
    for (low, high), ends in ((a, (0.25, 0.5)), (b, (-0.25, -0.125))):
        assert 0.0 < ends[0] - low < 1e-15
        assert 0.0 < high - ends[1] < 1e-15
    assert c == (-1.0, 1.0)
    assert coordinates(True, False, False).named([0.25, -5.0, 0.5]) == {"a!": 4.0, "b!": -5.0, "c!": 0.5}
    one, other, _ = coordinates(True, False, False).as_data()
    assert (one["name"], one["unit"], one["inverse"]) == ("a!", "kg", True)
    assert (other["inverse"], other["low"], other["high"]) == (False, -8.0, -4.0)


def test_only_a_range_without_zero_is_turned() -> None:
    assert coordinates().turned(1).inverse == (False, True, False)
    assert coordinates(False, True, False).turned(1).inverse == (False, False, False)
    assert coordinates().turned(2).inverse == (False, False, False)
    touching = Coordinates(None, None, (made(0.0, 1.0, "a"),), (False,))  # type: ignore[arg-type]
    assert touching.turned(0).inverse == (False,)


def test_how_far_coordinates_move_in_a_period() -> None:
    """1 / a moves by at most a' T / a^2, with the least a."""
    assert coordinates().changes((), 0.5) == ()
    plain = coordinates(False, True, False).changes((3.0, 8.0, 0.0), 0.5)
    assert plain == pytest.approx((1.5, 0.25, 0.0), rel=1e-14)
    assert plain[0] > 1.5
    assert plain[1] > 0.25


def test_halves_of_sides_are_never_too_short() -> None:
    assert 0.0 < box_maps._half(1.0, 3.0) - 1.0 < 1e-14
    assert box_maps._half(2.0, 2.0) == 0.0
    assert middle_of(1.0, 4.0) == 2.5
    assert box_maps._half(1.0, math.nextafter(1.0, 2.0)) >= 2.0**-52 - 2.0**-60


def test_the_oldest_of_what_is_known_goes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(box_maps, "_KEPT", 2)
    maps: Any = BoxMaps(SimpleNamespace(values=1, places=0), lambda values: {})  # type: ignore[arg-type]
    maps._over = lambda sides: sides
    assert [maps.open(one) for one in "abca"] == ["a", "b", "c", "a"]
    assert [*maps._known] == ["c", "a"]


def test_the_corner_at_which_a_quantity_is_worst() -> None:
    """Ends of the first and the last side are looked at; the side between stands in its middle."""
    values = np.array([3.0, 1.0, 4.0, 2.0])
    maps: Any = object.__new__(BoxMaps)
    maps.open = lambda sides: SimpleNamespace(interpolated=[0, 2])
    row = SimpleNamespace(at_corners=lambda opened: values)
    box = ((0.0, 1.0), (2.0, 4.0), (5.0, 6.0), ONE)

    def worst(limit: float, most: bool) -> Any:
        of: Any = SimpleNamespace(row=row, sign=-1.0 if most else 1.0)
        of.broken_by = lambda value: of.sign * (value - limit) < 0.0
        return BoxMaps.worst_corner(maps, box, of)

    assert worst(1.5, False) == ((0.0, 0.0), (3.0, 3.0), (6.0, 6.0), ONE)
    assert worst(0.5, False) is None
    assert worst(3.5, True) == ((1.0, 1.0), (3.0, 3.0), (5.0, 5.0), ONE)
    assert worst(4.5, True) is None
    row.at_corners = None  # type: ignore[assignment]
    assert worst(1.5, False) is None


def test_a_box_has_room_where_its_parameters_move() -> None:
    """Half of its width at both ends, but not beyond the whole."""
    core = ((1.0, 2.0), (4.0, 6.0), (3.0, 5.0), ONE)
    whole = ((0.0, 8.0), (0.0, 6.5), (2.5, 9.0), ONE)
    assert widened(core, whole, (0.1, 0.1, 0.1)) == ((0.5, 2.5), (3.0, 6.5), (2.5, 6.0), ONE)
    factor = (0.75, 1.0)  # which stays, though it has a width
    assert widened((*core[:3], factor), (*whole[:3], (0.5, 2.0)), (0.1, 0.1, 0.1))[3] == factor
    assert widened(core, whole, (0.0, 0.1, 0.0)) == ((1.0, 2.0), (3.0, 6.5), (3.0, 5.0), ONE)


# -- passages from one box to another ----------------------------------------------------------------------------------

LEFT = region(((0.0, 1.0), ONE), ((-0.5, 1.5), ONE))


@pytest.mark.parametrize(
    ("there", "change", "periods"),
    [
        ((1.0, 2.0), 0.1, 5),
        ((1.0, 2.0), 0.125, 4),  # after just four steps of an eighth it is at the end, not beyond
        ((1.625, 2.0), 0.125, 4),
        ((1.75, 2.0), 0.125, 0),  # further away than a step
        ((-1.0, 2.0), 0.1, 5),
        ((-0.5, 1.5), 0.1, 0),  # within the box: nothing leaves it
        ((-2.0, -0.4), 0.1, 5),
    ],
)
def test_periods_for_which_a_norm_is_kept(there: tuple[float, float], change: float, periods: int) -> None:
    assert _periods(LEFT, region((there, ONE), (there, ONE)), (change,)) == periods


def test_the_shorter_way_out_counts_and_what_stays_is_left_by_no_end() -> None:
    uneven = region(((0.0, 1.0), ONE), ((-0.25, 1.5), ONE))
    around = region(((-1.0, 2.0), ONE), ((-1.0, 2.0), ONE))
    assert _periods(uneven, around, (0.125,)) == 2
    still, beside = region(((0.0, 1.0), (1.0, 2.0)), ((-0.5, 1.5), (1.0, 2.0))), ((1.0, 2.0), (2.0, 3.0))
    assert _periods(still, region(beside, beside), (0.125,)) == 0, "they only touch"
    same = ((1.0, 2.0), (1.0, 2.0))
    assert _periods(still, region(same, same), (0.125,)) == 4


@pytest.mark.parametrize(
    ("radius", "within", "growth", "soon"),
    [
        (0.5, 1.0, 15.999, False),  # 15.999 / 2^4 < 1
        (0.5, 1.0, 16.0, True),
        (0.25, 0.5, 16.0, True),
        (0.25, 0.5, 15.9, False),
        (0.5, 1.0, 1.0, False),
    ],
)
def test_a_region_is_followed_too_soon_if_others_lengthen_more_than_it_shortens(
    radius: float, within: float, growth: float, soon: bool
) -> None:
    other = region(((1.0, 2.0), ONE), ((1.0, 2.0), ONE), ((1.0 / growth,),), 1e-9)
    one = region(LEFT.core, LEFT.box, ((1.0,),), radius)
    assert too_soon([one, other], (0.125,), within) == ([(one, other)] if soon else [])


def test_rounding_counts_over_many_periods() -> None:
    """In 1e8 periods a part of 2^-50 adds up to 9e-8: what shortens by 5e-8 only may lengthen."""
    for left, soon in ((5e-8, True), (2e-7, False)):
        growth = math.exp(-1e8 * math.log(1.0 - 1e-7) - left)
        other = region(((1.0, 2.0), ONE), ((1.0, 2.0), ONE), ((1.0 / growth,),), 1e-9)
        one = region(LEFT.core, LEFT.box, ((1.0,),), 1.0 - 1e-7)
        assert too_soon([one, other], (0.5e-8,), 1.0) == ([(one, other)] if soon else [])


def test_the_larger_core_of_a_passage_is_halved_along_the_side_that_parts_both() -> None:
    """By parts of the whole: 3 of 10 along the second side are more than 2 of 100 along the first."""
    small, large = region(((0.0, 2.0), (0.0, 2.0)), ()), region(((2.0, 4.0), (2.0, 6.0)), ())
    whole = ((0.0, 100.0), (0.0, 10.0))
    assert halved_places([(small, large)], whole) == {large.core: 1}
    even = region(((2.0, 4.0), (4.0, 6.0)), ())
    assert halved_places([(small, even), (small, large)], whole) == {small.core: 1, even.core: 1, large.core: 1}
    point = region(((2.0, 4.0), (2.0, 2.0)), ())
    assert halved_places([(point, point)], ((0.0, 100.0), (2.0, 2.0))) == {point.core: 0}
    far = region(((50.0, 52.0), (0.0, 2.0)), ())
    assert halved_places([(small, far)], whole) == {small.core: 0, far.core: 0}


# -- points of rest ----------------------------------------------------------------------------------------------------

CURVE = 3.0 * PolynomialBall.coordinate(-0.125, 0.125, 0) + 2.0
REST = RestPoint(
    curve=[CURVE],
    reach=np.array([0.5]),
    left=np.array([[2.0]]),
    step=Enclosed(np.array([[[-0.1]]]), np.array([[[0.01]]])),
    matrix=Enclosed(np.array([[[0.75]]]), np.array([[[0.1]]])),
)


def test_krawczyks_operator_of_one_number() -> None:
    """2 (0.1 + 0.01) + (abs(1 - 2 * 0.25) + 2 * 0.1) / 2 = 0.57."""
    assert REST.needed() == pytest.approx([0.57], rel=1e-11)
    assert REST.needed()[0] > 0.57


def test_a_point_of_rest_lies_within_the_reach_of_its_curve() -> None:
    (value,) = REST.values
    assert value.model.of.exponents.tolist() == [[0], [1]]
    assert value.ends() == pytest.approx((2.0 - 0.375 - 0.5, 2.0 + 0.375 + 0.5))
    assert (value - CURVE).ends() == pytest.approx((-0.5, 0.5))


def test_a_point_of_rest_as_data() -> None:
    assert REST.as_data() == {
        "centre": [2.0], "reach": [0.5], "left": [[2.0]], "step": [-0.1], "matrix": [[0.75]], "step_radius": [0.01],
        "matrix_radius": [[0.1]],
    }  # fmt: skip


def test_inverses_of_balls() -> None:
    balls = [[Ball(flint.arb(x)) for x in row] for row in ((0.5, 1.0), (0.0, 0.75))]
    np.testing.assert_allclose(near_inverse(balls), [[2.0, 8.0], [0.0, 4.0]])
    with pytest.raises(UndecidedError, match="does not come to rest"):
        near_inverse([[Ball(flint.arb(1))]])


# -- descents ----------------------------------------------------------------------------------------------------------


def test_a_smooth_maximum() -> None:
    """Of log 2 and 0 with a sharpness of 2: log 2 + log(1 + 1 / 4) / 2; slopes as 4 to 1."""
    value, slopes = largest(np.array([0.0, math.log(2.0)]), 2.0)
    assert value == pytest.approx(math.log(2.0) + 0.5 * math.log(1.25))
    assert slopes == pytest.approx([0.2, 0.8])


def test_what_is_unknown_and_its_slopes() -> None:
    left, rest, right = np.array([[1.0, -2.0], [0.5, 3.0]]), np.array([[0.1, 0.2], [0.3, 0.4]]), np.eye(2) + 0.5

    def size(a: Any, b: Any) -> float:
        return float(np.sqrt(((np.abs(a) @ rest @ np.abs(b)) ** 2).sum()))

    found, by_left, by_right = unknown(left, rest, right)
    assert found == pytest.approx(size(left, right))
    for place in np.ndindex(2, 2):
        step = np.zeros((2, 2))
        step[place] = 1e-6
        assert by_left[place] == pytest.approx((size(left + step, right) - size(left - step, right)) / 2e-6, rel=1e-6)
        assert by_right[place] == pytest.approx((size(left, right + step) - size(left, right - step)) / 2e-6, rel=1e-6)
    assert unknown(left, 0.0 * rest, right)[0] == 1e-300


def test_a_descent_from_unit_matrices_ends_at_the_least_value_or_once_it_is_enough() -> None:
    target, asked = np.array([[[2.0, 1.0], [0.0, 3.0]]]), list[float]()

    def bowl(x: Any, sharpness: float) -> tuple[float, Any]:
        asked.append(sharpness)
        if x[0, 0, 0] > 5.0:
            raise np.linalg.LinAlgError
        return float(((x - target) ** 2).sum()), 2.0 * (x - target)

    assert descended(bowl, (1, 2, 2), (1.0, 2.0)) == pytest.approx(target, abs=1e-4)
    assert {*asked} == {1.0, 2.0}
    assert descended(bowl, (1, 2, 2), (1.0, 2.0), 7.0).tolist() == [[[1.0, 0.0], [0.0, 1.0]]]
    close = descended(bowl, (1, 2, 2), (1.0, 2.0), 5.5)
    assert float(((close - target) ** 2).sum()) < 5.5
    with_nothing = descended(lambda x, s: (_ for _ in ()).throw(np.linalg.LinAlgError()), (1, 2, 2), (1.0,))
    assert with_nothing.tolist() == [[[1.0, 0.0], [0.0, 1.0]]]
