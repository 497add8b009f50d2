"""Elementary functions against references that share nothing with them: long doubles for many, mpmath for the worst."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from proofmass.blocks.arithmetic import elementary
from proofmass.runner.targets.elementwise import Elementwise

Long: Any = np.longdouble
LONG_IS_LONGER = np.finfo(np.longdouble).nmant >= 63
PRECISION = 1400  # bits: angles up to 2^1024, results near 1 of arguments near 0


@dataclass(frozen=True)
class Case:
    """A function, its references, and where its arguments lie."""

    function: Callable[..., float]
    long: Callable[..., Any]
    exact: Callable[..., Any]
    samplers: tuple[Callable[[Any, int], tuple[Any, ...]], ...]


def measured(case: Case, count: int, seed: int) -> tuple[float, tuple[float, ...]]:
    """The largest error among so many arguments, in units of the last place, and where it is."""
    dice, worst = np.random.default_rng(seed), (0.0, (math.nan,))
    names = case.function.__code__.co_varnames[: case.function.__code__.co_argcount]
    compiled = Elementwise(case.function, dict.fromkeys(names, float), float)
    with np.errstate(all="ignore"):
        for sampler in case.samplers:
            for begin in range(0, count // len(case.samplers), 1 << 18):
                arguments = sampler(dice, min(1 << 18, count // len(case.samplers) - begin))
                for place in _farthest(case, compiled(*arguments), arguments, 10):
                    at = tuple(float(column[place]) for column in arguments)
                    worst = max(worst, (error(case, at), at))
    return worst


def error(case: Case, arguments: tuple[float, ...]) -> float:
    """The error of one result, in units of the last place of the exact one."""
    with mpmath.workprec(PRECISION):
        exact = case.exact(*map(mpmath.mpf, arguments))
        result = case.function(*arguments)
        if math.isinf(result) or abs(exact) > mpmath.mpf(1.7976931348623157e308):
            return 0.0 if math.isinf(result) and abs(exact) > mpmath.mpf(1.797693134862315e308) else math.inf
        return float(abs(mpmath.mpf(result) - exact) / mpmath.mpf(math.ulp(float(exact))))


def _farthest(case: Case, results: Any, arguments: tuple[Any, ...], count: int) -> list[int]:
    """Where the results are farthest off the long doubles."""
    exact = case.long(*(np.asarray(column, dtype=Long) for column in arguments))
    errors = np.abs(results.astype(Long) - exact) / np.spacing(np.abs(exact.astype(float)))
    known = np.where(np.isfinite(errors), errors.astype(float), 0.0)
    return [int(place) for place in np.argpartition(known, -min(count, len(known)))[-count:]]


def _between(low: float, high: float) -> Callable[[Any, int], tuple[Any, ...]]:
    """Uniform, but with all bits of small numbers, which are multiples of the spacing of large ones otherwise."""
    return lambda dice, count: (np.clip(dice.uniform(low, high, count) * (1.0 + 1e-6 * dice.random(count)), low, high),)


def _octaves(low: float, high: float, signs: tuple[float, ...] = (-1.0, 1.0)) -> Callable[[Any, int], tuple[Any, ...]]:
    """Numbers of any size: uniform in their logarithm to the base of 2."""

    def sampler(dice: Any, count: int) -> tuple[Any, ...]:
        return (dice.choice(signs, count) * _sizes(dice, low, high, count),)

    return sampler


def _sizes(dice: Any, low: float, high: float, count: int) -> Any:
    """Numbers with uniform mantissas between powers of two."""
    return np.ldexp(1.0 + dice.random(count), dice.integers(int(low), int(high), count))


def _near(value: float) -> Callable[[Any, int], tuple[Any, ...]]:
    return lambda dice, count: (value - math.copysign(1.0, value) * _sizes(dice, -53, -1, count),)


def _pairs(*samplers: Callable[[Any, int], tuple[Any, ...]]) -> Callable[[Any, int], tuple[Any, ...]]:
    return lambda dice, count: tuple(sampler(dice, count)[0] for sampler in samplers)


def _of_powers(dice: Any, count: int) -> tuple[Any, ...]:
    """Bases and exponents whose power is any number there is, and a little more."""
    bases = np.where(dice.random(count) < 0.5, _sizes(dice, -1, 1, count), _sizes(dice, -1074, 1024, count))
    return bases, dice.uniform(-745.2, 709.8, count) / np.log(np.where(bases == 1.0, 2.0, bases))


def _small_powers(dice: Any, count: int) -> tuple[Any, ...]:
    return dice.uniform(0.0, 20.0, count), dice.integers(-40, 40, count) / dice.choice([1.0, 2.0, 3.0], count)


def _long_sine_of_turns(turns: Any) -> Any:
    halves = np.rint(2 * turns)
    return np.where(np.fmod(halves, 2) == 0, 1, -1) * np.sin(2 * _LONG_PI * (turns - halves / 2))


def _long_cosine_of_turns(turns: Any) -> Any:
    return np.sin(2 * _LONG_PI * (Long(0.25) - np.abs(turns - np.rint(turns))))


_LONG_PI = 4 * np.arctan(Long(1))
_ANGLES = (_between(-8.0, 8.0), _between(-1.5e6, 1.5e6), _octaves(-1000.0, 6.0), _octaves(20.0, 1024.0))
_TURNS = (_between(-1.0, 1.0), _between(-1e6, 1e6), _octaves(-1000.0, 50.0))
_SIDES = (_between(-1.0, 1.0), _octaves(-1000.0, 0.0), _near(1.0), _near(-1.0))
_POSITIVE = (_between(0.5, 2.0), _octaves(-1074.0, 1024.0, (1.0,)), _near(1.0))
_POINTS = (
    _pairs(_between(-1.0, 1.0), _between(-1.0, 1.0)),
    _pairs(_octaves(-1074.0, 1023.0), _octaves(-1074.0, 1023.0)),
    _pairs(_octaves(-1074.0, -1000.0), _octaves(-1074.0, -1000.0)),
    _pairs(_octaves(-10.0, 10.0), _octaves(-10.0, 10.0)),
)
_HYPERBOLIC = (_between(-1.0, 1.0), _between(-711.0, 711.0), _octaves(-1000.0, 9.0))

CASES = {
    case.function.__name__: case
    for case in (
        Case(elementary.sine_of_turns, _long_sine_of_turns, lambda x: mpmath.sinpi(2 * x), _TURNS),
        Case(elementary.cosine_of_turns, _long_cosine_of_turns, lambda x: mpmath.cospi(2 * x), _TURNS),
        Case(elementary.sine, np.sin, mpmath.sin, _ANGLES),
        Case(elementary.cosine, np.cos, mpmath.cos, _ANGLES),
        Case(elementary.tangent, np.tan, mpmath.tan, _ANGLES),
        Case(elementary.arctangent, np.arctan, mpmath.atan, (_between(-3.0, 3.0), _octaves(-1000.0, 1023.0))),
        Case(elementary.arctangent2, np.arctan2, mpmath.atan2, _POINTS),
        Case(elementary.arcsine, np.arcsin, mpmath.asin, _SIDES),
        Case(elementary.arccosine, np.arccos, mpmath.acos, _SIDES),
        Case(
            elementary.exponential, np.exp, mpmath.exp, (_between(-1.0, 1.0), _between(-745.2, 709.8), _octaves(-60, 9))
        ),
        Case(
            elementary.exponential_less_one,
            np.expm1,
            mpmath.expm1,
            (_between(-1.0, 1.0), _between(-60.0, 709.8), _octaves(-1000.0, 9.0)),
        ),
        Case(elementary.bounded_exponential, np.exp, mpmath.exp, (_between(-354.0, 354.0), _octaves(-60, 8))),
        Case(elementary.logarithm, np.log, mpmath.log, _POSITIVE),
        Case(elementary.logarithm_of_fraction, np.log, mpmath.log, (_between(0.0, 1.0), _octaves(-64.0, 0.0, (1.0,)))),
        Case(
            elementary.logarithm_of_one_plus,
            np.log1p,
            mpmath.log1p,
            (_between(-1.0, 2.0), _octaves(-1074.0, 1024.0, (1.0,)), _octaves(-1074.0, 0.0, (-1.0,)), _near(-1.0)),
        ),
        Case(elementary.binary_logarithm, np.log2, lambda x: mpmath.log(x) / mpmath.log(2), _POSITIVE),
        Case(elementary.decimal_logarithm, np.log10, lambda x: mpmath.log(x) / mpmath.log(10), _POSITIVE),
        Case(elementary.power, np.power, mpmath.power, (_of_powers, _small_powers)),
        Case(elementary.hypotenuse, np.hypot, mpmath.hypot, _POINTS),
        Case(elementary.hyperbolic_sine, np.sinh, mpmath.sinh, _HYPERBOLIC),
        Case(elementary.hyperbolic_cosine, np.cosh, mpmath.cosh, _HYPERBOLIC),
        Case(elementary.hyperbolic_tangent, np.tanh, mpmath.tanh, (*_HYPERBOLIC, _between(-22.0, 22.0))),
    )
}
