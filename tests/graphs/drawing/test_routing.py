"""Wires between layers and rows: no two share a line, also where many or those in a circle meet."""

import random
from itertools import combinations, permutations
from typing import NamedTuple

import pytest

from proofmass.graphs.drawing.routing import GRID, LARGEST_SIFTED, Bar, Heights, WireTree, add_line, channel, walked
from proofmass.graphs.drawing.rows import _corridor


def dealt(seed: int, count: int) -> dict[int, Heights]:
    """Nets of one pin on each side, at heights at random."""
    draw, heights = random.Random(seed), range(0, 2 * count * GRID, GRID)
    left, right = draw.sample(heights, count), draw.sample(heights, count)
    return {net: ([left[net]], [right[net]]) for net in range(count)}


def shared(bars: dict[int, list[Bar]]) -> list[tuple[Bar, Bar]]:
    """Bars that lie on top of each other, and those of other nets whose wires to the sides do."""
    every = [(net, bar) for net, of_net in bars.items() for bar in of_net]
    upright = [
        (one, other)
        for (_, one), (_, other) in combinations(every, 2)
        if one.track == other.track and one.low < other.high + GRID and other.low < one.high + GRID
    ]
    return upright + [
        (one, other)
        for net, one in every
        for of, other in every
        if net != of and one.track >= other.track and set(one.left) & set(other.right)
    ]


@pytest.mark.parametrize(
    ("seed", "count"),
    [(9340, 12), (1, LARGEST_SIFTED + 20), pytest.param(2, LARGEST_SIFTED, marks=pytest.mark.exhaustive)],
)
def test_no_two_wires_of_a_gap_share_a_line(seed: int, count: int) -> None:
    tracks, bars = channel(dealt(seed, count))
    assert shared(bars) == []
    assert tracks == 1 + max(bar.track for of_net in bars.values() for bar in of_net)


def crossed(bars: list[tuple[int, Bar]]) -> int:
    """Return how often level pieces of wires cross bars of others: to the right of their own, and to the left of it."""
    return sum(
        other.low < y < other.high
        for net, bar in bars
        for of, other in bars
        if net != of and bar.track != other.track
        for y in (bar.right if bar.track < other.track else bar.left)
    )


@pytest.mark.parametrize("seed", range(8))
def test_bars_stand_where_the_fewest_wires_cross(seed: int) -> None:
    """No order of all the bars has fewer crossings, where every order is allowed."""
    nets = {net: (left, [right[0] + GRID // 2]) for net, (left, right) in dealt(seed, 5).items()}
    bars = [(net, bar) for net, of_net in channel(nets)[1].items() for bar in of_net]
    found, every = crossed(bars), list[int]()
    for tracks in permutations(range(len(bars))):
        for (_, bar), track in zip(bars, tracks, strict=True):
            bar.track = track
        every.append(crossed(bars))
    assert found == min(every)


class Row(NamedTuple):
    """A row whose nets leave it at known places."""

    places: dict[str, int]

    @property
    def leaves(self) -> dict[bool, dict[str, int]]:
        return {True: self.places, False: self.places}

    def across(self, name: str, _down: bool) -> int:
        return self.places[name]


def test_two_wires_that_change_places_between_rows_get_a_line_more() -> None:
    trees: dict[str, WireTree] = {}
    levels: list[dict[tuple[bool, str], int]] = [{}, {}]
    bottom = _corridor(trees, [Row({"a": 0, "b": 100}), Row({"a": 100, "b": 0})], levels, 0, 0)  # type: ignore[arg-type]
    lines = {name: {tuple(sorted((a, b))) for a, near in tree.items() for b in near} for name, tree in trees.items()}
    assert lines["a"].isdisjoint(lines["b"])
    assert {name: len(own) for name, own in lines.items()} == {"a": 3, "b": 1}, "one goes by way of a line between"
    heights = [y for tree in trees.values() for _, y in tree]
    assert min(heights) > 0
    assert max(heights) < bottom
    assert [set(level) for level in levels] == [{(True, "a"), (True, "b")}, {(False, "a"), (False, "b")}]


def test_a_line_from_a_point_to_itself_leads_nowhere() -> None:
    tree: WireTree = {}
    add_line(tree, (0, 0), (0, 0), (10, 0))
    assert walked(tree, (0, 0)) == {(10, 0): (0, 0)}
