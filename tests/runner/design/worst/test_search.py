"""Descents inside a box of two parameters, of functions with a known worst place."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from proofmass.runner.design.quantities.evaluator import STABLE
from proofmass.runner.design.worst.search import Badness, BoxSearch, Side
from proofmass.runner.host.progress import Progress

Function = Callable[[float, float], tuple[float | None, float, float]]


def search_of(function: Function, growth: Function | None = None, progress: Progress | None = None) -> BoxSearch:
    """A search whose quantity is a function of x and y, which may have no value, with its derivatives."""

    def reading(of: Function, place: dict[str, float], slopes: bool) -> Any:
        value, *by = of(place["x"], place["y"])
        known = SimpleNamespace(value=value, slopes=dict(zip("xy", by, strict=True)) if slopes else {})
        return None if value is None else known

    def readings(place: dict[str, float], slopes: bool) -> dict[str, Any]:
        assert all(abs(part) <= 1.0 for part in place.values())
        found = {"q": reading(function, place, slopes)}
        return {**found, f"{STABLE}main": reading(growth, place, slopes)} if growth else found

    ranges = [SimpleNamespace(others=lambda place: [-place])] * 2
    box = SimpleNamespace(
        ranges=ranges, values=lambda key: dict(zip("xy", key, strict=True)), slopes=lambda *_: [{"x": 1.0}, {"y": 1.0}]
    )
    return BoxSearch(SimpleNamespace(readings=readings, why={}), box, 3, progress, None)  # type: ignore[arg-type]


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_worst_place_is_inside(size: float, sign: float) -> None:
    """A hill about (0.3, -0.4), or a hollow there, in any unit."""

    def hill(x: float, y: float) -> tuple[float, float, float]:
        scale = -sign * size
        return scale * (5.0 - (x - 0.3) ** 2 - (y + 0.4) ** 2), -2.0 * scale * (x - 0.3), -2.0 * scale * (y + 0.4)

    search, side = search_of(hill), Side("q", sign)
    search._inside(side, search.at((1.0, 0.9)))
    worst = search.worst(side)
    assert worst.place == pytest.approx((0.3, -0.4), abs=1e-4)
    assert search.badness(worst, side) == Badness(False, pytest.approx(5.0 * size, rel=1e-6))


def test_progress_is_out_of_the_places_expected_and_never_all_before_the_end() -> None:
    told: list[tuple[int, int]] = []
    search = search_of(lambda x, y: (x + y, 1.0, 1.0), progress=lambda done, of: told.append((done, of)))
    for x in (0.0, 0.1, 0.2, 0.3):
        search.at((x, 0.0))
    assert told == [(1, 3), (2, 3), (3, 4), (4, 5)]


def test_a_slope_ends_at_the_side_of_the_box() -> None:
    """x + 0.1 y^2 is worst at x = 1 and y = -1 where y begins below 0; from there all points outwards."""
    search, side = search_of(lambda x, y: (x + 0.1 * y * y, 1.0, 0.2 * y)), Side("q", -1.0)
    search._inside(side, search.at((0.0, -0.5)))
    assert search.worst(side).place == (1.0, -1.0)
    number = len(search.cases)
    search._inside(side, search.at((1.0, -1.0)))
    assert len(search.cases) == number


def test_where_a_loop_is_unstable_its_growth_counts() -> None:
    """No value beyond x = 0.5, from where the growth rises to y = 0.25: worse than any value."""

    def value(x: float, y: float) -> tuple[float | None, float, float]:
        return (x if x < 0.5 else None), 1.0, 0.0

    def growth(x: float, y: float) -> tuple[float | None, float, float]:
        return x - (y - 0.25) ** 2, 1.0, -2.0 * (y - 0.25)

    search, side = search_of(value, growth), Side("q", -1.0)
    search._inside(side, search.at((0.25, 0.75)))
    worst = search.worst(side)
    assert worst.readings["q"] is None
    assert worst.place == pytest.approx((1.0, 0.25), abs=1e-3)
    start = search.at((0.75, 0.75), slopes=True)
    assert search.gradient(start, side).tolist() == pytest.approx([1.0, -1.0])
    assert search.badness(start, side) == Badness(True, pytest.approx(0.5))
    number = len(search.cases)
    search._inside(side, start)
    assert len(search.cases) == number, "a descent begins where there is a value"


@pytest.mark.parametrize(("corners", "all_of_them"), [(4, True), (3, False)])
def test_few_corners_are_all_tried(corners: int, all_of_them: bool) -> None:
    """Where nothing changes, derivatives name (1, 1), and from there one parameter at a time is turned."""
    search = search_of(lambda x, y: (1.0, 0.0, 0.0))
    search.search([Side("q", 1.0)], corners, samples=1, seed=1)
    assert ((-1.0, -1.0) in search.cases) == all_of_them
    assert {(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (0.0, 0.0), (0.0, -1.0), (1.0, 0.0)} <= search.cases.keys()
    assert len(search.random) == 1
