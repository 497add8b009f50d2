"""Linearity of the rates of a group in its states and inputs but for a constant, or once some inputs are held.

Where f(s z) - f(0) = s (f(z) - f(0)) for scales s sixty orders of magnitude up and down, in the
same bits where f(0) = 0, and f(z) - f(0) is the sum of what each entry of z does alone, no limit,
dead zone or product can hide. An input w that multiplies others, as the rate of rotation does, is a
factor: f(z, w) - f(0, w) is linear in z for each w.
"""

import itertools
import math
from collections.abc import Callable, Sequence

_Rates = Callable[[Sequence[float]], list[float]]  # of states and inputs, one behind the other

_SCALES = (1.0, -1.0, 2.0, 2.0**-13, 2.0**-26, 2.0**-39, 2.0**-60, 2.0**60, 2.0**-200, 2.0**200)
_NEAR_SCALES = (-1.0, 2.0, 2.0**-10, 2.0**10)  # for functions that subtract a constant, which leaves rounding
_SIGNS = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0, 1.0))
_FACTORS = (0.625, -1.75, 3.0)
_ROUNDING, _OF_CONSTANT = 1e-9, 1e-12  # the latter where no factor is held


def factors_of(rates: _Rates, size: int, candidates: Sequence[int]) -> tuple[int, ...] | None:
    """Entries that multiply others, the rates being linear in the rest but for a constant; () where
    they are so in all of them, None where they are not in that sense. `candidates` are the entries
    that may be factors: held inputs."""
    try:
        if all(_is_linear(rates, size, (), 0.0, signs, _SCALES) for signs in _SIGNS):
            return ()
        factors = tuple(place for place in candidates if _multiplies(rates, size, place))
        free = not factors or len(factors) == size
        linear = not free and all(
            _is_linear(rates, size, factors, value, signs, _NEAR_SCALES) for signs in _SIGNS for value in _FACTORS
        )
    except ArithmeticError:
        return None
    return factors if linear else None


def _multiplies(rates: _Rates, size: int, place: int) -> bool:
    """Return whether an input changes what another entry does."""
    point = [1.375 * float(i == place) for i in range(size)]
    rest, offset = rates([0.0] * size), rates(point)
    for other in range(size):
        if other == place:
            continue
        alone = rates([float(i == other) for i in range(size)])
        both = rates([value + float(i == other) for i, value in enumerate(point)])
        for a, b, c, d in zip(alone, both, offset, rest, strict=True):
            if not abs((b - c) - (a - d)) <= _ROUNDING * (abs(a) + abs(b) + abs(c) + abs(d)):
                return True
    return False


def _is_linear(
    rates: _Rates, size: int, factors: Sequence[int], value: float, signs: Sequence[float], scales: Sequence[float]
) -> bool:
    """Return whether the rates are linear in the other entries but for a constant, with the factors at
    values about the given one."""
    fixed = {place: value * (1.0 + 0.25 * number) for number, place in enumerate(factors)}
    offset = rates([fixed.get(i, 0.0) for i in range(size)])
    rounding = _ROUNDING if factors else _OF_CONSTANT

    def at(point: Sequence[float]) -> list[float]:
        return [rate - c for rate, c in zip(rates([fixed.get(i, v) for i, v in enumerate(point)]), offset, strict=True)]

    point = [sign * (1.0 + 0.375 * n) for n, sign in zip(range(size), itertools.cycle(signs), strict=False)]
    once = at(point)
    sizes = [abs(c) for c in offset]
    for scale in scales:
        scaled = at([scale * v for v in point])
        if any(
            (not factors and not c and found != scale * rate)
            or not abs(found - scale * rate) <= rounding * (abs(scale * rate) + c)
            for found, rate, c in zip(scaled, once, sizes, strict=True)
        ):
            return False
    alone = [at([v * float(i == j) for i in range(size)]) for j, v in enumerate(point) if j not in fixed]
    for rate, parts, c in zip(once, zip(*alone, strict=True), sizes, strict=True):
        if not abs(rate - math.fsum(parts)) <= _ROUNDING * (math.fsum(map(abs, parts)) + c):
            return False
    return True
