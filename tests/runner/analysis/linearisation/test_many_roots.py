"""Roots of polynomials of many degrees whose roots are known as fractions, and values against exact arithmetic."""

import math
import random
from fractions import Fraction
from typing import Any

import flint
import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.many_roots import (
    PolynomialValues,
    _are_apart,
    _is_told,
    _starts,
    _turns_up,
    many_roots,
)
from proofmass.runner.analysis.linearisation.rational import BITS

Root = tuple[Fraction, Fraction]  # real part, and imaginary part above zero, which stands for a pair


def polynomial_of(roots: list[Root]) -> Any:
    product = flint.fmpz_poly([1])
    for real, imaginary in roots:
        low = math.lcm(real.denominator, imaginary.denominator)
        x, y = int(real * low), int(imaginary * low)
        product *= flint.fmpz_poly([x * x + y * y, -2 * x * low, low * low] if y else [-x, low])
    return product


def as_ball(real: Fraction, imaginary: Fraction) -> Any:
    return flint.acb(*(flint.arb(flint.fmpq(v.numerator, v.denominator)) for v in (real, imaginary)))


def circle(dice: random.Random, pairs: int, size: tuple[float, float]) -> list[Root]:
    """Random pairs between two sizes, apart from each other."""
    roots = list[Root]()
    for k in range(pairs):
        radius, angle = dice.uniform(*size), (k + dice.uniform(0.2, 0.8)) * math.pi / pairs
        roots.append(
            (
                Fraction(round(radius * math.cos(angle) * 2**20), 2**20),
                Fraction(round(radius * math.sin(angle) * 2**20), 2**20),
            )
        )
    return roots


NEAR = [(1 - Fraction(k, 10**7), Fraction(0)) for k in (1, 3, 8)] + [(1 - Fraction(5, 10**6), Fraction(3, 10**6))]
KINDS: dict[str, list[Root]] = {
    "one": [(Fraction(-3, 7), Fraction(0))],
    "a pair": [(Fraction(1, 3), Fraction(2, 5))],
    "outside": [(Fraction(-9, 2), Fraction(0)), (Fraction(4), Fraction(7, 2)), (Fraction(1, 9), Fraction(1, 8))],
    "close to 1": [*NEAR, *circle(random.Random(1), 20, (0.6, 0.9))],
    "a filter": circle(random.Random(2), 60, (0.8, 1.3)),
    "far apart": [(Fraction(10) ** k, Fraction(0)) for k in range(-4, 5)] + [(Fraction(-7, 5), Fraction(1, 3))],
    "on the circle": [
        (Fraction(3, 5), Fraction(4, 5)),
        (Fraction(-1), Fraction(0)),
        *circle(random.Random(3), 9, (0.2, 0.6)),
    ],
    "next to the circle": [(Fraction(3, 5), Fraction(4, 5) + s * Fraction(1, 10**5)) for s in (-1, 1)]
    + circle(random.Random(4), 12, (0.5, 0.9)),
}


@pytest.mark.parametrize("zeros", [0, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_known_roots(kind: str, zeros: int) -> None:
    """Each lies in a ball of its own, on its side of the circle; the 16 next to the circle to hundreds of bits."""
    flint.ctx.prec = BITS
    roots, polynomial = KINDS[kind], polynomial_of(KINDS[kind])
    balls = many_roots(flint.fmpz_poly([*[0] * zeros, *polynomial.coeffs()]), BITS)
    assert balls is not None
    assert len(balls) == zeros + polynomial.degree()
    assert all(ball == 0 for ball in balls[:zeros])
    left = balls[zeros:]
    truths = [as_ball(r, i) for r, i in roots] + [as_ball(r, -i) for r, i in roots if i]
    sharp = sorted(abs(float(abs(truth)) - 1.0) for truth in truths)[: 16 if len(truths) > 16 else len(truths)]
    for truth in truths:
        (ball,) = [ball for ball in left if ball.overlaps(truth)]
        radius = max(float(ball.real.rad()), float(ball.imag.rad()))
        size = float(abs(truth))
        assert radius < 1e-9 * max(size, 0.25)
        if abs(size - 1.0) <= sharp[-1]:
            assert radius < 1e-60
        assert (size < 1.0 - 1e-12) == bool(abs(ball) < 1)
        left.remove(ball)
    assert not left


@pytest.mark.parametrize("number", [64, 100, 257])
def test_roots_of_unity(number: int) -> None:
    """z^n = 1, of which none may be said to lie inside or outside; z^n = 1/3 lies inside."""
    flint.ctx.prec = BITS
    balls = many_roots(flint.fmpz_poly([-1, *[0] * (number - 1), 1]), BITS)
    assert balls is not None
    angles = sorted((math.atan2(float(b.imag.mid()), float(b.real.mid())) + 1e-9) % (2 * math.pi) for b in balls)
    assert angles == pytest.approx([1e-9 + 2 * math.pi * k / number for k in range(number)], abs=1e-14)
    assert all(abs(ball).contains(1) for ball in balls if max(float(ball.real.rad()), float(ball.imag.rad())) > 1e-100)
    inside = many_roots(flint.fmpz_poly([-1, *[0] * (number - 1), 3]), BITS)
    assert inside is not None
    assert all(bool(abs(ball) < 1) for ball in inside)


@pytest.mark.parametrize("number", range(3))
def test_against_certified_roots(number: int) -> None:
    """Random coefficients, many of them 0: Arb finds the same roots by another way."""
    flint.ctx.prec = BITS
    dice = random.Random(number)
    coefficients = [dice.randint(-(10**6), 10**6) * (dice.random() < (1.0, 0.4, 0.1)[number]) for _ in range(40)]
    coefficients[0], coefficients[-1] = 12345, 54321
    polynomial = flint.fmpz_poly(coefficients)
    balls = many_roots(polynomial, BITS)
    assert balls is not None
    for truth, times in polynomial.complex_roots():
        assert times == 1
        assert sum(bool(ball.overlaps(truth)) for ball in balls) == 1


def test_double_roots_are_left_to_others() -> None:
    """A root that is there twice has no ball of its own; close to 0, where both lie inside, that does not matter."""
    flint.ctx.prec = BITS
    others = circle(random.Random(5), 8, (0.4, 0.8))
    double = [(Fraction(9, 10), Fraction(0))] * 2
    assert many_roots(polynomial_of([*others, *double]), BITS) is None
    assert (
        many_roots(polynomial_of([*others, (Fraction(1, 2), Fraction(3, 4)), (Fraction(1, 2), Fraction(3, 4))]), BITS)
        is None
    )
    small = [(Fraction(1, 20), Fraction(0)), (Fraction(1, 20) + Fraction(1, 10**6), Fraction(0))]
    balls = many_roots(polynomial_of([*others, *small]), BITS)
    assert balls is not None
    assert len(balls) == 18


@pytest.mark.parametrize("digits", [12, 18])
def test_roots_closer_to_1_than_doubles_next_to_it(digits: int) -> None:
    """1 - 10^-18 and 1 - 3 10^-18 are one double, and two roots."""
    flint.ctx.prec = BITS
    slow = [(1 - Fraction(k, 10**digits), Fraction(0)) for k in (1, 3)]
    balls = many_roots(polynomial_of([*slow, *circle(random.Random(7), 6, (0.5, 0.8))]), BITS)
    assert balls is not None
    for truth in (as_ball(*root) for root in slow):
        assert sum(bool(ball.overlaps(truth)) for ball in balls) == 1


def test_bits_that_do_not_tell_the_side_of_a_root() -> None:
    """Two roots on the circle, 10^-5 from each other, lie in balls apart, of 10^-14 where so few bits are wanted."""
    flint.ctx.prec = BITS
    roots = [(Fraction(3, 5) + shift, Fraction(4, 5)) for shift in (Fraction(0), Fraction(1, 10**5))]
    polynomial = polynomial_of([*roots, *circle(random.Random(8), 6, (0.5, 0.8))])
    assert many_roots(polynomial, BITS) is not None
    assert many_roots(polynomial, 20) is None


def ball(real: float, imaginary: float, radius: float) -> Any:
    return flint.acb(flint.arb(real, radius), flint.arb(imaginary, radius))


def test_balls_that_touch() -> None:
    """A square of half an edge r lies within 2 r: two of them are apart from 4 r on, whichever is larger."""
    low = ball(-0.5, 0.25, 0.0625)
    for way in (0.25, 0.25j):
        for part, apart in ((0.99, False), (1.0, False), (1.01, True)):
            other = -0.5 + 0.25j + part * way
            assert _are_apart([low, ball(other.real, other.imag, 0.0625)]) is apart
    assert not _are_apart([ball(-0.5, 0.0, 0.3), ball(0.5, 0.0, 1e-9), ball(0.0, 0.0, 1e-9)]), "a wide one before"
    assert not _are_apart([ball(-0.5, 0.0, 1e-9), ball(0.5, 0.0, 0.6)]), "a wide one after"
    assert _are_apart([])


def test_sides_of_the_circle() -> None:
    """Balls on one side, and around the circle: where a ball is next to nothing, its root may lie on it."""
    assert all(_is_told(ball(0.6 * size, 0.8 * size, 0.1)) for size in (0.5, 2.0))
    assert not _is_told(ball(0.0, -1.0, 1e-25))
    assert _is_told(ball(0.0, -1.0, 1e-40))


def test_no_roots() -> None:
    assert many_roots(flint.fmpz_poly([7]), BITS) == []
    assert many_roots(flint.fmpz_poly([0, 0, 7]), BITS) == [0, 0]


def exact(polynomial: Any, place: complex) -> complex:
    """The value at a place that is 1 + a double, to all digits."""
    return complex(polynomial(flint.acb(1) + flint.acb(place.real, place.imag)))


POLYNOMIALS = {
    "dense": flint.fmpz_poly([random.Random(6).randint(-999, 999) for _ in range(41)]),
    "sparse": flint.fmpz_poly([3, *[0] * 6, -7, *[0] * 60, 2, *[0] * 25, 1]),
    "a power of z": flint.fmpz_poly([*[0] * 30, 5]),
    "huge": flint.fmpz_poly([3**400, -(7**300), 5**350, 2**900 + 1]),
    "close to 1": polynomial_of(NEAR) ** 2,
    "number": flint.fmpz_poly([-12]),
}
PLACES = np.array(
    [1e-9, -1e-6 + 2e-6j, -1e-3j, -0.004, 0.009j, -0.3 + 0.2j, -0.5, -0.999, 1j - 1.0, -2.0, -1.0 - 0.8j], dtype=complex
)


@pytest.mark.parametrize("name", POLYNOMIALS)
def test_values(name: str) -> None:
    """In the power of two of the largest coefficient, next to 1 to all digits."""
    flint.ctx.prec = BITS
    polynomial = POLYNOMIALS[name]
    values = PolynomialValues(polynomial)
    sizes = [abs(int(v)) for v in polynomial.coeffs()]
    assert 2 ** (values.octaves - 1) <= max(sizes) < 2**values.octaves
    found = values((1.0 + PLACES).astype(np.complex128), PLACES)
    for place, value in zip(PLACES.tolist(), found.tolist(), strict=True):
        truth = (
            exact(polynomial, place)
            if values.octaves < 1000
            else complex(polynomial(flint.acb(1) + flint.acb(place.real, place.imag)) / flint.arb(2) ** values.octaves)
            * 2.0**0
        )
        scale = 2.0**values.octaves if values.octaves < 1000 else 1.0
        terms = sum(size / 2**values.octaves * abs(1.0 + place) ** k for k, size in enumerate(sizes))
        near = abs(place) * max(polynomial.degree(), 1) < 0.5
        assert abs(value - truth / scale) <= (
            1e-13 * abs(truth / scale) if near and name == "close to 1" else 1e-14 * terms
        )
    assert values.are_near(PLACES).tolist() == [abs(p) * max(polynomial.degree(), 1) < 0.5 for p in PLACES.tolist()]


@pytest.mark.parametrize("name", [name for name in POLYNOMIALS if name != "number"])
def test_newton_steps(name: str) -> None:
    """p / p' on both sides of the circle, and what rounding may make of it: enough, and no hundred times too much."""
    flint.ctx.prec = BITS
    polynomial = POLYNOMIALS[name]
    slope = polynomial.derivative()
    places = np.concatenate([PLACES, [0.7 + 0.2j, 3.0, -5.0 + 2.0j, -2.0 - 1e-3j]])
    steps, errors = PolynomialValues(polynomial).ratio(places.astype(np.complex128))
    largest = 0.0
    for place, step, error in zip(places.tolist(), steps.tolist(), errors.tolist(), strict=True):
        z = flint.acb(1) + flint.acb(place.real, place.imag)
        truth = complex(polynomial(z) / slope(z))
        condition = abs(complex(slope.derivative()(z) * polynomial(z) / slope(z) ** 2))
        assert abs(step - truth) <= error * (1.0 + condition) + 1e-14 * abs(truth) * (1.0 + condition)
        terms = sum(abs(int(v)) * flint.arb(abs(1.0 + place)) ** k for k, v in enumerate(polynomial.coeffs()))
        rounding = 2.0**-52 * float(terms / abs(slope(z)))
        if abs(place) * polynomial.degree() >= 0.5:
            assert 2.0 * rounding < error < 8.0 * rounding
        largest = max(largest, error)
    assert largest > 0.0


def test_roots_are_looked_for_on_the_circles_of_newtons_polygon() -> None:
    """Of 100 - 101 x + x^2 at 100 / 101 and 101; of -8 + x^3 at three places of the size 2; a small x counts not."""
    first, second = _starts([100, -101, 1])
    assert (abs(first), abs(second)) == pytest.approx((100.0 / 101.0, 101.0))
    assert (np.angle(first), np.angle(second)) == pytest.approx((0.7, 1.1))
    three = _starts([-8, 0, 0, 1])
    assert np.abs(three) == pytest.approx([2.0] * 3)
    turns = np.mod(np.angle(three), 2.0 * math.pi)
    assert turns == pytest.approx([(0.7 + 2.0 * math.pi * k) / 3.0 for k in range(3)])
    assert np.abs(_starts([-800, 1, 0, 100])) == pytest.approx([2.0] * 3)


def test_a_corner_of_the_polygon_lies_above_the_line_past_it() -> None:
    assert _turns_up((2, 3.0), (3, 3.5), (5, 5.0))
    assert not _turns_up((2, 3.0), (3, 4.0), (5, 5.0))
    assert _turns_up((2, 3.0), (3, 3.75), (6, 6.0)), "on the line"
