"""Explicit methods keep the order conditions of all rooted trees, and step as their coefficients say.

The elementary weight of a tree whose root carries trees t1 ... tk is that of each node: the product over them of
A times theirs; b times the weight of the tree is 1 / gamma (Hairer, Nørsett, Wanner I, theorem II.2.13).
"""

import itertools
import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from proofmass.runner.continuous.methods import EXPLICIT, Explicit, explicit_step

Tree = tuple[Any, ...]  # the trees that its root carries


def trees(order: int) -> set[Tree]:
    """Every rooted tree of so many nodes, as sorted tuples."""
    return {
        tuple(sorted(branches))
        for parts in _partitions(order - 1, order - 1)
        for branches in itertools.product(*map(trees, parts))
    }


def _partitions(total: int, most: int) -> Iterator[tuple[int, ...]]:
    if total == 0:
        yield ()
    for first in range(min(total, most), 0, -1):
        yield from ((first, *rest) for rest in _partitions(total - first, first))


def size(tree: Tree) -> int:
    return 1 + sum(map(size, tree))


def density(tree: Tree) -> int:
    return size(tree) * math.prod(map(density, tree))


def weights(tree: Tree, a: Any) -> Any:
    found = np.ones(len(a))
    for branch in tree:
        found = found * (a @ weights(branch, a))
    return found


def table(method: Explicit) -> Any:
    stages = len(method.stages)
    return np.array([[*row, *[0.0] * (stages - len(row))] for row in method.stages])


def test_trees_are_counted() -> None:
    """Table II.2.2 of the same."""
    assert [len(trees(order)) for order in range(1, 7)] == [1, 1, 2, 4, 9, 20]


@pytest.mark.parametrize("method", EXPLICIT.values(), ids=EXPLICIT)
def test_order_conditions(method: Explicit) -> None:
    a, b = table(method), np.array(method.weights)
    assert a.sum(axis=1) == pytest.approx(method.nodes, abs=1e-14)
    estimates = [(b, method.order)]
    if method.differences:
        estimates.append((b - np.array(method.differences), method.order - 1))
    for row, order in estimates:
        for tree in itertools.chain.from_iterable(map(trees, range(1, order + 1))):
            assert float(row @ weights(tree, a)) == pytest.approx(1.0 / density(tree), abs=1e-14), tree
        higher = [float(row @ weights(tree, a)) * density(tree) - 1.0 for tree in trees(order + 1)]
        assert max(map(abs, higher)) > 1e-4, "the order is no higher"


@pytest.mark.parametrize(("name", "stages"), [("runge_kutta_4", 4), ("dormand_prince", 7)])
def test_a_step_is_that_of_the_coefficients(name: str, stages: int) -> None:
    """x' = t x and y' = x - t, by exact fractions."""
    method, time, h, start = EXPLICIT[name], Fraction(1, 8), Fraction(1, 16), (Fraction(3, 4), Fraction(-1, 2))
    calls: list[Any] = []

    def rates(at: Any, state: list[Any]) -> list[Any]:
        calls.append(at)
        return [at * state[0], state[0] - at]

    found = explicit_step(method, rates, float(time), float(h), list(map(float, start)))
    assert len(calls) == stages
    slopes: list[list[Fraction]] = []
    for node, row in zip(method.nodes, method.stages, strict=True):
        moved = [
            x + h * sum(Fraction(f) * s[i] for f, s in zip(row, slopes, strict=False)) for i, x in enumerate(start)
        ]
        slopes.append(rates(time + Fraction(node) * h, moved))
    for row, values, begin in zip((method.weights, method.differences), found, (start, (0, 0)), strict=False):
        exact = [x + h * sum(Fraction(f) * s[i] for f, s in zip(row, slopes, strict=True)) for i, x in enumerate(begin)]
        assert values == pytest.approx([float(value) for value in exact], rel=1e-15, abs=1e-17)
    assert len(found) == 1 + bool(method.differences)
