"""Positive real roots of polynomials whose roots are known, and against all complex roots by FLINT."""

import random
from fractions import Fraction
from typing import Any

import flint
import pytest

from proofmass.runner.analysis.linearisation.real_roots import isolated

BITS = 512


def product(roots: list[Fraction]) -> Any:
    """The polynomial with these roots."""
    whole = flint.fmpz_poly([1])
    for root in roots:
        whole *= flint.fmpz_poly([-root.numerator, root.denominator])
    return whole


def assert_found(polynomial: Any, expected: set[Fraction]) -> None:
    """A ball for each root, in order, that holds it and little else."""
    found = isolated(polynomial, BITS)
    flint.ctx.prec = 4 * BITS
    assert len(found) == len(expected)
    for ball, root in zip(found, sorted(expected), strict=True):
        exact = flint.arb(flint.fmpq(root.numerator, root.denominator))
        assert ball.overlaps(exact)
        assert ball.rad() < exact * flint.arb(2) ** (2 - BITS)


@pytest.mark.parametrize("seed", range(40))
def test_rational_roots_beside_others(seed: int) -> None:
    dice = random.Random(seed)
    roots = [Fraction(dice.randint(-50, 200), dice.choice([1, 2, 3, 7, 64, 1000])) for _ in range(dice.randint(1, 14))]
    if seed % 3 == 0:
        roots += [1 + Fraction(1, 10**30), Fraction(1)]
    others = flint.fmpz_poly([1, 1]) ** dice.choice([0, 5, 60]) * flint.fmpz_poly([9, dice.randint(-3, 3), 1])
    assert_found(product(roots) * others, {root for root in roots if root > 0})


@pytest.mark.defect("H550", before="margins of a loop of 53 states have no end", after="they take a second")
def test_a_cluster_at_minus_one_costs_nothing() -> None:
    """Delays leave it on the axis of a sampled loop."""
    for power in (53, 200):
        assert_found(flint.fmpz_poly([1, 1]) ** power * flint.fmpz_poly([-1, 3]), {Fraction(1, 3)})
        assert isolated((flint.fmpz_poly([1, 1]) ** power + flint.fmpz_poly([5])) ** 2, BITS) == []


def test_wilkinson_and_powers_of_two() -> None:
    assert_found(product([Fraction(n) for n in range(1, 41)]), {Fraction(n) for n in range(1, 41)})
    powers = [Fraction(2) ** k for k in range(-60, 61, 5)]
    assert_found(product(powers) ** 2, set(powers))


@pytest.mark.parametrize("seed", range(20))
def test_random_coefficients(seed: int) -> None:
    dice = random.Random(seed)
    polynomial = flint.fmpz_poly([dice.randint(-99, 99) for _ in range(dice.randint(2, 40))] + [1])
    assert_as_all_roots(polynomial)


def test_two_roots_that_nearly_are_one() -> None:
    """Mignotte's polynomial: they are 1e-37 apart."""
    assert_as_all_roots(flint.fmpz_poly([0] * 41 + [1]) - 2 * flint.fmpz_poly([-1, 50]) ** 2)


def assert_as_all_roots(polynomial: Any) -> None:
    found = isolated(polynomial, BITS)
    flint.ctx.prec = 2 * BITS
    roots = [root.real for root, _ in polynomial.complex_roots() if root.imag.is_zero() and root.real > 0]
    assert len(found) == len(roots)
    for ball, root in zip(found, sorted(roots), strict=True):
        assert abs(ball - root) < root * flint.arb(2) ** -256
