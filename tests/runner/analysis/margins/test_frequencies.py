"""Zeros and highest points on a grid, refined until rounding ends them."""

import numpy as np
import pytest

from proofmass.runner.analysis.margins.bracketed import zeros_between
from proofmass.runner.analysis.margins.frequencies import Samples, crossings, highest


def measured(values: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    return values.real


def test_crossings_and_dips_between_points() -> None:
    """(w - 3)(w - 7) crosses twice; (w - 5.03)^2 - 1e-8 dips below zero for 2e-4 only, on a grid of steps of 0.1."""
    w = np.linspace(0.05, 10.0, 100)
    wide = Samples.on(w, lambda v: (v - 3.0) * (v - 7.0) + 0j)
    assert crossings(wide, measured) == pytest.approx([3.0, 7.0], rel=1e-14)
    narrow = Samples.on(w, lambda v: (v - 5.03) ** 2 - 1e-8 + 0j)
    assert crossings(narrow, measured) == pytest.approx([5.0299, 5.0301], rel=1e-9)
    apart = Samples.on(w, lambda v: (v - 5.03) ** 2 + 1e-8 + 0j)
    assert crossings(apart, measured) == []
    assert crossings(wide.up_to(5.0), measured) == pytest.approx([3.0])


def test_the_highest_of_several_peaks() -> None:
    w = np.linspace(0.1, 10.0, 60)
    found = highest(
        Samples.on(w, lambda v: np.exp(-((v - 2.0) ** 2)) + 1.001 * np.exp(-((v - 8.04) ** 2)) + 0j), measured
    )
    assert found == pytest.approx((8.04, 1.001), rel=1e-7)
    assert highest(Samples.on(w, lambda v: v + 0j), measured) == pytest.approx((10.0, 10.0))
    assert highest(Samples.on(w, lambda v: 1.0 / v + 0j), measured) == pytest.approx((0.1, 10.0))
    assert highest(Samples.on(w, lambda v: 3.0 - (v - 0.2) ** 2 + 0j), measured) == pytest.approx((0.2, 3.0), abs=1e-7)
    assert highest(Samples.on(w, lambda v: 3.0 - (v - 9.9) ** 2 + 0j), measured) == pytest.approx((9.9, 3.0), abs=1e-7)


def test_a_zero_at_an_end_is_that_end() -> None:
    ends = np.array([1.0, 1.0]), np.array([2.0, 2.5])
    assert zeros_between(lambda v: v - 1.0, *ends).tolist() == [1.0, 1.0]
    assert zeros_between(lambda v: v * v - 2.0, *ends) == pytest.approx([2.0**0.5, 2.0**0.5], rel=1e-15)
