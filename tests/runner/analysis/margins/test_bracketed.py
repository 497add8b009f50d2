"""Zeros and minima between places, of functions whose zeros and minima are known."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from proofmass.runner.analysis.margins.bracketed import lowest_between, zeros_between
from proofmass.runner.host.arrays import Array

Curve = Callable[[Array], Array]


class Counted:
    """A function that counts its calls, and how many places it was called for."""

    def __init__(self, curve: Curve) -> None:
        self.curve, self.calls, self.places = curve, 0, 0

    def __call__(self, x: Array) -> Array:
        self.calls, self.places = self.calls + 1, self.places + x.size
        return self.curve(x)


ZEROS: dict[str, tuple[Curve, float, float, float, int]] = {  # function, ends, zero, calls that are enough
    "line": (lambda x: 3.0 * x - 6.0, 0.0, 5.0, 2.0, 5),
    "cosine": (np.cos, 1.0, 2.0, 0.5 * math.pi, 9),
    "cube": (lambda x: (x - 0.3) ** 3, 0.0, 1.0, 0.3, 56),
    "steep": (lambda x: np.exp(40.0 * x) - 2.0, -1.0, 1.0, math.log(2.0) / 40.0, 16),
    "flat": (lambda x: np.tanh(1e3 * (x - 0.123)), 0.0, 1.0, 0.123, 18),
    "jump": (lambda x: np.where(x < 0.7, -1.0, 2.0), 0.0, 1.0, 0.7, 55),
    "pole": (lambda x: 1.0 / x - 1e-3, 1.0, 1e6, 1e3, 20),
    "small": (lambda x: x - 1e-9, 0.0, 1.0, 1e-9, 6),
}


@pytest.mark.parametrize("name", ZEROS)
@pytest.mark.parametrize("turned", [False, True])
def test_zeros(name: str, turned: bool) -> None:
    curve, low, high, zero, enough = ZEROS[name]
    ends = (np.array([high]), np.array([low])) if turned else (np.array([low]), np.array([high]))
    function = Counted(curve)
    assert zeros_between(function, *ends, scale=0.0) == pytest.approx([zero], rel=1e-5 if name == "cube" else 4e-15)
    assert function.calls <= 1.25 * enough  # another last digit may cost some


def test_a_scale_is_accuracy_enough() -> None:
    """A zero near 0 is only wanted to the rounding of the scale; an absolute error a billionth of it takes longer."""
    counts = []
    for scale in (1e9, 0.0):
        function = Counted(lambda x: np.expm1(x - 1e-3) + (x - 1e-3) ** 3)
        found = zeros_between(function, np.array([-1.0]), np.array([2.0]), scale)
        assert found == pytest.approx([1e-3], abs=max(2e-15 * scale, 1e-17))
        counts.append(function.calls)
    assert counts[0] < counts[1]


def test_many_at_once_are_each_as_alone() -> None:
    """Zeros of x^3 - v by v^(1/3), also where an end is one; those that are known are not called for again."""
    v = np.array([0.5, 1.0, 8.0, 2.0, 0.0, 3.3])
    low, high = np.array([0.0, 1.0, 1.0, 1.0, 0.0, 1.0]), np.array([1.0, 2.0, 2.0, 2.0, 1.0, 2.0])
    names: list[int] = []

    def curve(x: Array) -> Array:
        names.append(len(x))
        near = np.argmin(np.abs(x[:, None] ** 3 - v), axis=1)
        sizes = {len(v): v, 3: v[[0, 3, 5]]}.get(len(x), v[near])
        return np.asarray(x**3 - sizes)

    assert zeros_between(curve, low, high) == pytest.approx(np.cbrt(v), rel=4e-15, abs=1e-15)
    assert names[:3] == [6, 6, 3]
    assert max(names[3:]) == 3
    assert len(zeros_between(curve, np.zeros(0), np.zeros(0))) == 0


def test_the_first_place_wins_where_there_is_no_change() -> None:
    """Without a change of sign the better end is the answer."""
    found = zeros_between(lambda x: x**2 + 1.0, np.array([1.0, -3.0]), np.array([4.0, -2.0]))
    assert found.tolist() == [1.0, -2.0]


MINIMA: dict[str, tuple[Curve, float, float, float, float, int]] = {  # function, bracket, minimum, enough calls
    "parabola": (lambda x: 2.0 + (x - 0.3) ** 2, -1.0, 0.0, 2.0, 0.3, 32),
    "cosine": (np.cos, 2.0, 2.5, 5.0, math.pi, 22),
    "quartic": (lambda x: (x - 1.0) ** 4, -3.0, 0.5, 2.0, 1.0, 67),
    "corner": (lambda x: np.abs(x - 0.77), 0.0, 0.5, 3.0, 0.77, 42),
    "skewed": (lambda x: x - np.log(x), 1e-3, 0.5, 1e3, 1.0, 42),
    "falling": (lambda x: np.exp(-3.0 * x) + 0.2 * x, 0.0, 0.1, 20.0, math.log(15.0) / 3.0, 47),
}


@pytest.mark.parametrize("name", MINIMA)
@pytest.mark.parametrize("mirrored", [False, True])
def test_minima(name: str, mirrored: bool) -> None:
    curve, low, middle, high, place, enough = MINIMA[name]
    function = Counted((lambda x: curve(-x)) if mirrored else curve)
    bracket = (-high, -middle, -low) if mirrored else (low, middle, high)
    at, value = lowest_between(function, *(np.array([x]) for x in bracket))
    at = -at if mirrored else at
    assert at == pytest.approx([place], rel=3e-7 if name != "quartic" else 3e-4)
    assert value == pytest.approx(curve(np.array([place])), rel=1e-13, abs=2e-10 if name == "corner" else 1e-14)
    assert value[0] == curve(at)[0]
    assert function.calls <= 1.25 * enough  # another last digit may cost some


def test_many_minima_at_once() -> None:
    """Places of one bracket do not move those of another, and a bracket without a lower middle stays."""
    centres = np.array([0.2, 0.9, 0.5, 3.0])
    at, value = lowest_between(
        lambda x: np.cosh(x - centres), np.zeros(4), np.array([0.4, 0.5, 0.5, 0.5]), np.array([1.0, 1.9, 1.0, 1.0])
    )
    assert at[:3] == pytest.approx(centres[:3], abs=3e-8)
    assert value[:3] == pytest.approx(np.ones(3), rel=1e-14)
    assert 0.5 <= at[3] <= 1.0
