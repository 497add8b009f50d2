"""Which rates are linear, in what, and which are not: by functions whose answer is known."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from proofmass.runner.continuous.linearity import factors_of

Rates = Callable[[Sequence[Any]], list[Any]]
ALL = (0, 1, 2)


@pytest.mark.parametrize(
    ("rates", "candidates", "expected"),
    [
        (lambda z: [2.0 * z[0] - z[1], 0.5 * z[2]], ALL, ()),
        (lambda z: [0.0, 0.0], ALL, ()),
        (lambda z: [z[0] + 1.0, z[1]], (), ()),  # a constant beside
        (lambda z: [3.0, z[1] - 2.0], ALL, ()),
        (lambda z: [z[0] * z[2] + 1.0, z[1]], (2,), (2,)),
        (lambda z: [z[0] * z[2] + 1.0, z[1]], (), None),
        (lambda z: [z[0] * z[0] + 1.0, z[1]], ALL, None),
        (lambda z: [min(z[0], 1e50) + 1.0, z[1]], ALL, None),  # a limit far away, beside a constant
        (lambda z: [(z[0] if abs(z[0]) > 1e-9 else 0.0) + 1.0, z[1]], ALL, None),  # a small dead zone
        (lambda z: [z[0] + (z[1] if z[0] * z[1] > 0.0 else 0.0) + 1.0, 0.0], (), None),
        (lambda z: [z[0] * z[2], z[1]], (2,), (2,)),
        (lambda z: [z[0] * z[2], z[1]], (), None),
        (lambda z: [z[0] * z[2], z[1]], (0, 1), (0,)),
        (lambda z: [z[0] * z[1] + z[0] * z[2], 0.0], (1, 2), (1, 2)),
        (lambda z: [z[0] * z[1] * z[2], 0.0], (1, 2), None),  # each is looked at beside one other: it is stepped
        (lambda z: [z[0] * z[0], 0.0], ALL, None),
        (lambda z: [z[0] * math.cos(z[2]) + z[1] * math.sin(z[2]), 0.0], (2,), (2,)),
        (lambda z: [z[0] + math.cos(z[2]), z[1] * z[2]], (2,), (2,)),  # a sum that the input alone makes
        (lambda z: [abs(z[0]), z[1]], ALL, None),
        (lambda z: [max(z[0], -1e30), z[1]], ALL, None),  # limits far away
        (lambda z: [min(z[0], 1e50), z[1]], ALL, None),
        (lambda z: [z[0] if abs(z[0]) > 1e-30 else 0.0, z[1]], ALL, None),  # a small dead zone
        (lambda z: [z[0] if abs(z[0]) > 1e-50 else 0.0, z[1]], ALL, None),
        (lambda z: [z[0] + (z[1] if z[0] * z[1] > 0.0 else 0.0), 0.0], (), None),  # scales, but is no sum
        (lambda z: [1.0 / z[0], z[1]], (), None),  # no value at rest
        (lambda z: [z[0] ** 3 * z[2], z[1]], (2,), None),
        (lambda z: [min(z[0], 500.0) * z[2], z[1]], (2,), None),
    ],
)
def test_factors_of_known_rates(rates: Rates, candidates: Sequence[int], expected: tuple[int, ...] | None) -> None:
    assert factors_of(rates, 3, candidates) == expected
