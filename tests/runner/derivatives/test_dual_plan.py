"""The hold of dual matrices against mpmath: values as without duals, derivatives of the exponential itself."""

import random

import mpmath
import pytest

from proofmass.runner.continuous.exact_hold import hold
from proofmass.runner.derivatives.dual import dual, plain, slopes_of
from proofmass.runner.derivatives.dual_plan import dual_hold

PERIOD = 2e-5


def exact(a: list[list[float]], b: list[list[float]]) -> "mpmath.matrix":
    """[exp(A T), integral of exp(A t) B] to 50 digits."""
    n, m = len(a), len(b[0])
    joined = mpmath.zeros(n + m)
    for i in range(n):
        for j, value in enumerate([*a[i], *b[i]]):
            joined[i, j] = mpmath.mpf(value) * PERIOD
    return mpmath.expm(joined, method="taylor")


@pytest.mark.parametrize(
    ("mass", "damping", "stiffness"),
    [(1e-7, 4e-4, 3e-3), (5e-8, 3.4e-3, 49.6), (1e-7, 1e-9, 500.0), (1e-7, 2 * (1e-7 * 3e-3) ** 0.5, 3e-3)],
)
def test_derivatives_of_the_hold_of_a_pendulum(mass: float, damping: float, stiffness: float) -> None:
    given = {"mass": mass, "damping": damping, "stiffness": stiffness}
    m, c, k = (dual(value, {name: 1.0}) for name, value in given.items())
    a, b = [[0.0, 1.0], [-k / m, -c / m]], [[0.0], [1.0 / m]]
    found = [[*left, *right] for left, right in zip(*dual_hold(a, b, PERIOD), strict=True)]
    transition, entry = hold([[plain(v) for v in row] for row in a], [[plain(v) for v in row] for row in b], PERIOD)
    assert [[plain(v) for v in row] for row in found] == [[*x, *y] for x, y in zip(transition, entry, strict=True)]
    with mpmath.workdps(50):
        for name in given:

            def at(value: "mpmath.mpf", name: str = name) -> "mpmath.matrix":
                p = {key: mpmath.mpf(v) for key, v in given.items()} | {name: value}
                rows = [[0, 1], [-p["stiffness"] / p["mass"], -p["damping"] / p["mass"]]]
                return exact(rows, [[0], [1 / p["mass"]]])

            step = mpmath.mpf(given[name]) * mpmath.mpf(10) ** -15
            slope = (at(given[name] + step) - at(given[name] - step)) / (2 * step)
            for i in range(2):
                for j in range(3):
                    got = slopes_of(found[i][j]).get(name, 0.0)
                    assert got == pytest.approx(float(slope[i, j]), rel=1e-10), (name, i, j)


def test_second_level_is_not_needed_for_what_has_no_slopes() -> None:
    dice = random.Random(1)
    a = [[dice.gauss(0.0, 1.0) for _ in range(3)] for _ in range(3)]
    assert dual_hold(a, [[], [], []], 0.1) == hold(a, [[], [], []], 0.1)
