"""Fit the polynomials of the elementary functions: `python benchmarks/elementary_fits.py` prints their coefficients.

Remez' exchange on the error times a weight (Muller, Elementary Functions, 3rd ed., chapter 3), in 60 digits. The error
that is printed is that of the coefficients as they stand there, rounded to numbers one after the other; those behind
one are fitted again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath
from mpmath import mp, mpf

POINTS = 400  # where the error is looked at


@dataclass(frozen=True)
class Fit:
    """A function, the weight of its error, the interval, and how many coefficients the polynomial has."""

    function: Callable[[Any], Any]
    weight: Callable[[Any], Any]
    low: Any
    high: Any
    coefficients: int


def _sine(z: Any) -> Any:
    r = mpmath.sqrt(z)
    return (mpmath.sin(r) - r) / r**3


def _cosine(z: Any) -> Any:
    return (mpmath.cos(mpmath.sqrt(z)) - 1 + z / 2) / z**2


def _arctangent(z: Any) -> Any:
    t = mpmath.sqrt(z)
    return (mpmath.atan(t) - t) / t**3


def _exponential(r: Any) -> Any:
    return (mpmath.expm1(r) - r - r**2 / 2) / r**3


def _logarithm(z: Any) -> Any:
    s = mpmath.sqrt(z)
    return (mpmath.log((1 + s) / (1 - s)) - 2 * s - 2 * s**3 / 3 - 2 * s**5 / 5) / s**7


def fits() -> dict[str, Fit]:
    """Every polynomial by the function that it is of; the intervals are a little wider than what is asked of it."""
    mp.dps = 60
    quarter = (mp.pi / 4 * mpf("1.0001")) ** 2
    half_two = mp.log(2) / 2 * mpf("1.0001")
    s = (mp.sqrt(2) - 1) / (mp.sqrt(2) + 1) * mpf("1.0001")
    tiny = mpf(10) ** -12
    return {
        "sine: (sin r - r) / r^3 in r^2": Fit(_sine, lambda z: z, tiny, quarter, 6),
        "cosine: (cos r - 1 + r^2 / 2) / r^4 in r^2": Fit(_cosine, lambda z: z * z, tiny, quarter, 6),
        "arctangent: (atan t - t) / t^3 in t^2": Fit(_arctangent, lambda z: z, tiny, mpf("0.0561"), 9),
        "exponential: (exp r - 1 - r - r^2 / 2) / r^3 in r": Fit(
            _exponential, lambda r: max(abs(r), mpf("0.02")) ** 2, -half_two, half_two, 10
        ),
        "logarithm: (ln((1 + s) / (1 - s)) - 2 s - 2 s^3 / 3 - 2 s^5 / 5) / s^7 in s^2": Fit(
            _logarithm, lambda z: z**3, tiny, s * s, 7
        ),
    }


def rounded(fit: Fit) -> tuple[list[float], float]:
    """Coefficients as numbers, lowest power first, and the largest weighted error that is left."""
    places = [_place(fit, (k + mpf(1) / 2) / POINTS) for k in range(POINTS)]
    values, weights = [fit.function(x) for x in places], [fit.weight(x) for x in places]
    coefficients = [mpf(float(c)) for c in _exchanged(places, values, weights, fit.coefficients)]
    for k in range(1, fit.coefficients if fit.low > 0 else 0):
        rest = [(v - mpmath.polyval(coefficients[:k][::-1], x)) / x**k for x, v in zip(places, values, strict=True)]
        weights_of_rest = [w * x**k for x, w in zip(places, weights, strict=True)]
        coefficients[k:] = [mpf(float(c)) for c in _exchanged(places, rest, weights_of_rest, fit.coefficients - k)]
    every = zip(places, values, weights, strict=True)
    errors = (abs(w * (mpmath.polyval(coefficients[::-1], x) - v)) for x, v, w in every)
    return list(map(float, coefficients)), float(max(errors))


def _place(fit: Fit, share: Any) -> Any:
    """Chebyshev's places, denser towards the ends."""
    return (fit.low + fit.high) / 2 - (fit.high - fit.low) / 2 * mpmath.cospi(share)


def _exchanged(places: list[Any], values: list[Any], weights: list[Any], count: int) -> list[Any]:
    """Coefficients of the polynomial whose weighted error is smallest on the places."""
    chosen = [(2 * k + 1) * len(places) // (2 * count + 2) for k in range(count + 1)]
    for _ in range(30):
        rows = [[places[i] ** k for k in range(count)] + [(-1) ** n / weights[i]] for n, i in enumerate(chosen)]
        solved = mpmath.lu_solve(mpmath.matrix(rows), mpmath.matrix([values[i] for i in chosen]))
        coefficients, level = list(solved)[:count], abs(solved[count])
        every = zip(places, values, weights, strict=True)
        errors = [w * (mpmath.polyval(coefficients[::-1], x) - v) for x, v, w in every]
        if max(map(abs, errors)) <= level * mpf("1.0001"):
            break
        chosen = _alternating(errors, count + 1)
    return coefficients


def _alternating(errors: list[Any], count: int) -> list[int]:
    """The places of the largest errors of alternating sign; the smaller ones at the ends are left out."""
    peaks: list[int] = []
    for i, error in enumerate(errors):
        if peaks and (errors[peaks[-1]] > 0) == (error > 0):
            if abs(error) > abs(errors[peaks[-1]]):
                peaks[-1] = i
        else:
            peaks.append(i)
    while len(peaks) > count:
        peaks.pop(0 if abs(errors[peaks[0]]) < abs(errors[peaks[-1]]) else -1)
    return peaks


def parts(value: Any, *bits: int) -> list[float]:
    """A number as a sum of numbers of so many bits each, the last of them of 53."""
    terms = []
    for width in bits:
        unit = mpf(2) ** (int(mpmath.floor(mpmath.log(abs(value), 2))) + 1 - width)
        terms.append(float(mpmath.floor(value / unit) * unit))
        value -= mpf(terms[-1])
    return [*terms, float(value)]


def main() -> None:
    for name, fit in fits().items():
        coefficients, error = rounded(fit)
        print(f"{name}; error 2^{float(mpmath.log(error, 2)):.1f}")
        print("".join(f"    {c!r},\n" for c in coefficients), end="")
    print("pi / 2 in three parts of 33 bits and one:", parts(mp.pi / 2, 33, 33, 33))
    print("pi / 2 in two:", parts(mp.pi / 2, 53))
    print("ln 2 in two parts of 42 bits and one:", parts(mp.log(2), 42, 42))
    pairs = {
        "atan 1/2": mp.atan(mpf(1) / 2),
        "2 / 3": mpf(2) / 3,
        "2 / 5": mpf(2) / 5,
        "1 / ln 2": 1 / mp.log(2),
        "1 / ln 10": 1 / mp.log(10),
    }
    for name, value in pairs.items():
        high = float(value)
        print(f"{name} in two:", [high, float(value - mpf(high))])
    with mp.workprec(1400):
        print("2 / pi in pieces of 53 bits, times 2^200:", parts(mpf(2) ** 201 / mp.pi, *[53] * 22)[:-1])


if __name__ == "__main__":
    main()
