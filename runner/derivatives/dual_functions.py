"""The functions of blocks made to take dual numbers: copies that find `math`, `int` and `float` with derivatives.

A copy shares the code of the function; only what it finds among its globals differs. Functions that
it calls are copied too.
"""

import builtins
import functools
import math
import types
from collections.abc import Callable, Collection, Mapping
from typing import Any

import flint

from proofmass.blocks.arithmetic import elementary, rounding
from proofmass.runner.derivatives.ball import Ball, of_balls, of_series
from proofmass.runner.derivatives.dual import SIGNALS, UNDEFINED, Dual, chained, plain, slopes_of, value_of, with_plain
from proofmass.runner.derivatives.polynomial import PolynomialBall, Turned
from proofmass.runner.derivatives.slopes import SLOPES_OF_ONE, SLOPES_OF_TWO, WIDE_SLOPES

dual_math: Any = types.SimpleNamespace(**vars(math))  # stands in for `math`; filled below


@functools.cache
def for_duals(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, working on dual numbers and plain ones alike."""
    return with_functions(function, _REPLACED)


RULES = (rounding.round_half_even, rounding.round_down)
# Rules by which quantisers choose a level; some quantisers have two levels.
LEVELS = (rounding.nearest_level, rounding.nearest_even_level, rounding.two_level)


def quantises(function: Callable[..., Any]) -> bool:
    """Return whether a function, or one that it calls, rounds as `blocks.arithmetic.rounding`."""
    return reaches(function, RULES)


def reaches(function: Any, wanted: Collection[Any]) -> bool:
    """Return whether a function is one of some, or calls one."""
    return _reaches(function, wanted, set())


def _reaches(function: Any, wanted: Collection[Any], visited: set[Any]) -> bool:
    if function in wanted:
        return True
    if not isinstance(function, types.FunctionType) or function in visited:
        return False
    visited.add(function)
    named = (function.__globals__.get(name) for name in _names(function.__code__))
    return any(_reaches(value, wanted, visited) for value in named if isinstance(value, types.FunctionType))


def with_quantisers(
    function: Callable[..., Any],
    quantise: Callable[[Callable[[Any], Any], Any], Any],
    level: Callable[..., Any],
) -> Any:
    """Return a function as `for_duals` does, where `quantise(rule, value)` takes the place of each
    rule of rounding.

    `level(rule, *arguments)` is the same of a rule that chooses one of some levels.
    """
    own: dict[Any, Any] = {rule: functools.partial(quantise, _REPLACED[rule]) for rule in RULES}
    own |= {rule: functools.partial(level, rule) for rule in LEVELS}
    return with_functions(function, _REPLACED | own)


def compared(rule: Callable[..., Any], first: Any, second: Any) -> Any:
    """The value of which a rule of `LEVELS` chooses a level."""
    return second if rule is rounding.two_level else first


def with_functions(function: Callable[..., Any], replaced: Mapping[Any, Callable[..., Any]]) -> Callable[..., Any]:
    """A copy of a function that calls others in the place of some."""
    if function in replaced:
        return replaced[function]
    if not isinstance(function, types.FunctionType):
        return function
    return _copy(function, {}, replaced)


def _copy(
    function: types.FunctionType, copies: dict[Any, Any], replaced: Mapping[Any, Callable[..., Any]]
) -> Callable[..., Any]:
    """A copy whose globals are filled afterwards, since functions may call themselves."""
    names: dict[str, Any] = {"__builtins__": builtins}
    copy = types.FunctionType(function.__code__, names, function.__name__, function.__defaults__, function.__closure__)
    copy.__kwdefaults__ = function.__kwdefaults__
    copies[function] = copy
    for name in _names(function.__code__):
        value = function.__globals__.get(name, getattr(builtins, name, None))
        if value is math:
            names[name] = dual_math
        elif isinstance(value, Callable) and value in replaced:  # type: ignore[arg-type]
            names[name] = replaced[value]
        elif isinstance(value, types.ModuleType):
            names[name] = _Module(value, replaced)
        elif isinstance(value, types.FunctionType):
            names[name] = copies[value] if value in copies else _copy(value, copies, replaced)
        elif name in function.__globals__:
            names[name] = value
    return copy


class _Module:
    """A module whose functions take dual numbers."""

    def __init__(self, module: types.ModuleType, replaced: Mapping[Any, Callable[..., Any]]) -> None:
        self._module, self._replaced = module, replaced

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._module, name)
        return with_functions(value, self._replaced) if callable(value) else value


def _names(code: types.CodeType) -> set[str]:
    inner = (_names(constant) for constant in code.co_consts if isinstance(constant, types.CodeType))
    return {*code.co_names}.union(*inner)


_ROUND = frozenset({elementary.sine_of_turns, elementary.cosine_of_turns})  # they come round with each turn


def _of_one(
    function: Callable[[float], Any], slope: Callable[[Any], Any], wide: Callable[[Any], Any] | None = None
) -> Callable[[Any], Any]:
    """A function of one number, with its derivative by the chain rule: of balls it may have a form of its own."""

    def apply(x: Any) -> Any:
        if isinstance(x, Turned) and x.turn == 1.0 and function in _ROUND:
            return apply(x.of)
        if isinstance(x, PolynomialBall):
            return x.through(apply)
        if isinstance(x, flint.arb_series):
            return of_series(apply, wide or slope, x)
        if not isinstance(x, Dual):
            return of_balls(function, x) if isinstance(x, Ball) else function(x)
        value = apply(x.value)
        try:
            by_x = wide(x.value) if wide and isinstance(plain(x.value), Ball) else slope(x.value)
            return chained(x.level, value, (_enclosing(by_x), x.slopes))
        except (ZeroDivisionError, ValueError):  # as for the square root at 0, which has a value and no slope
            return chained(x.level, value, (UNDEFINED, x.slopes))

    return apply


def _of_two(
    function: Callable[[float, float], float], slopes: Callable[[Any, Any], tuple[Any, Any]]
) -> Callable[[Any, Any], Any]:
    """A function of two numbers, with both its derivatives by the chain rule."""

    def apply(x: Any, y: Any) -> Any:
        level = max((number.level for number in (x, y) if isinstance(number, Dual)), default=None)
        if level is None:
            return of_balls(function, x, y) if isinstance(x, Ball) or isinstance(y, Ball) else function(x, y)
        here, there = value_of(x, level), value_of(y, level)
        value = apply(here, there)
        try:
            by_x, by_y = map(_enclosing, slopes(here, there))
        except (ZeroDivisionError, ValueError):
            by_x, by_y = UNDEFINED, UNDEFINED
        return chained(level, value, (by_x, slopes_of(x, level)), (by_y, slopes_of(y, level)))

    return apply


def _enclosing(slope: Any) -> Any:
    """Return a slope; one that is a ball also for the exact values of the doubles in its formula, such as pi."""
    return slope.widened() if isinstance(slope, Ball) else slope


def _itself(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function on dual numbers, made when it is called: for mixed second derivatives slopes have slopes."""
    return lambda *arguments: for_duals(function)(*arguments)


def _counting(function: Callable[[float], Any]) -> Callable[[Any], Any]:
    return lambda x: _counted(function, plain(x))


def _counted(function: Callable[[float], Any], number: Any) -> Any:
    if not isinstance(number, Ball):
        return function(number)
    if function in (math.isnan, math.isinf, math.isfinite):
        return function is math.isfinite
    if function is math.floor:
        return math.floor(number)
    if function is rounding.nearest_integer and isinstance(number, PolynomialBall | Turned):
        return number.nearest_integer()
    return math.ceil(number) if function is math.ceil else float(round(number))


def _converting(kind: Callable[..., Any]) -> Callable[..., Any]:
    """`int` or `float`: a change of type, which for a dual number changes nothing."""

    def convert(x: Any = 0, *more: Any) -> Any:
        real = kind is float and isinstance(x, Ball)
        return x if real or isinstance(x, Dual | PolynomialBall) else kind(x, *more)

    return convert


def _hypot(*sides: Any) -> Any:
    if any(isinstance(plain(side), Ball) for side in sides):
        return dual_math.sqrt(sum(side * side for side in sides))
    length = math.hypot(*map(plain, sides))
    if length == 0.0:
        return sum((abs(side) for side in sides), 0.0)  # a corner: undefined in every direction
    return dual_math.sqrt(sum(side * side for side in sides))


def _atan2(y: Any, x: Any) -> Any:
    """Angle of (x, y), from the angle of the quarter that keeps the quotient small."""
    if isinstance(plain(y), Ball) or isinstance(plain(x), Ball):
        return _REPLACED[elementary.arctangent2](y, x)
    if not isinstance(y, Dual) and not isinstance(x, Dual):
        return math.atan2(y, x)
    if plain(x) == plain(y) == 0:
        return math.atan2(plain(y), plain(x)) + abs(y) + abs(x)  # the angle of no length: undefined
    angle = dual_math.atan(y / x) if abs(x) >= abs(y) else -dual_math.atan(x / y)
    return angle + (math.atan2(plain(y), plain(x)) - plain(angle))


def _power(base: Any, exponent: Any) -> Any:
    if isinstance(plain(base), Ball) or isinstance(plain(exponent), Ball):
        return _REPLACED[elementary.power](base, exponent)
    if not isinstance(base, Dual) and not isinstance(exponent, Dual):
        return math.pow(base, exponent)
    if isinstance(exponent, Dual):
        if plain(base) == 0 and plain(exponent) > 0:
            return _power(base, plain(exponent))  # 0 for every exponent nearby
        return dual_math.exp(exponent * dual_math.log(base))
    if exponent == 0:
        return 1.0

    def slope(x: Any) -> Any:
        if plain(x) == 0 and exponent < 1.0:
            raise ZeroDivisionError
        return exponent * _power(x, exponent - 1.0)

    return _of_one(lambda x: math.pow(x, exponent), slope)(base)


def _sign(number: Any) -> float:
    if isinstance(number, Ball):
        return 1.0 if number > 0 else -1.0
    return math.copysign(1.0, number)


def _frexp(x: Any) -> tuple[Any, int]:
    exponent = math.frexp(plain(x))[1]
    return _ldexp(x, -exponent), exponent


def _ldexp(x: Any, exponent: int) -> Any:
    return x * math.ldexp(1.0, exponent) if isinstance(x, Dual) else math.ldexp(x, exponent)


def _fsum(terms: Any) -> Any:
    kept = list(terms)
    return sum(kept, 0.0) if any(isinstance(term, Dual) for term in kept) else math.fsum(kept)


_WHOLE = ("floor", "ceil", "isfinite", "isnan", "isinf")
_REST: dict[str, Callable[..., Any]] = {
    "hypot": _hypot,
    "atan2": _atan2,
    "pow": _power,
    "copysign": lambda size, sign: size * (1.0 if _sign(plain(size)) == _sign(plain(sign)) else -1.0),
    "fabs": abs,
    "trunc": _converting(math.trunc),
    "fmod": lambda x, y: x - y * math.trunc(plain(x) / plain(y)) if isinstance(x, Dual) else math.fmod(x, y),
    "frexp": _frexp,
    "ldexp": _ldexp,
    "fsum": _fsum,
}
vars(dual_math).update({name: _counting(getattr(math, name)) for name in _WHOLE} | _REST)


def _wrapped(mantissa: Any, low_bits: int, sign: int) -> Any:
    if not isinstance(mantissa, Dual):
        return rounding.wrapped(mantissa, low_bits, sign)
    return mantissa.wrapped(-sign, low_bits - sign)


def _rounding(rule: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def rounded(value: Any) -> Any:
        if _stands(value):
            return with_plain(value, rule(plain(value)))
        return value if isinstance(value, Dual | PolynomialBall) else _counted(rule, value)

    return rounded


_clip: Callable[..., Any] = rounding.clip  # of numbers with slopes


def _choosing(rule: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    def chosen(value: Any, last: Any) -> Any:
        if not isinstance(value, Dual | PolynomialBall):
            return rule(round(value) if isinstance(value, Ball) else value, last)
        inside = _clip(value, 0.0, last)
        return with_plain(inside, float(rule(plain(value), plain(last)))) if _stands(value) else inside

    return chosen


def _stands(value: Any) -> bool:
    """Return whether parameters alone move a number: a carrier, which is rounded as in the run."""
    return isinstance(value, Dual) and value.level < SIGNALS and not isinstance(plain(value), Ball)


_OURS: dict[Any, Callable[..., Any]] = {
    rounding.round_half_even: _rounding(rounding.round_half_even),
    rounding.round_down: _rounding(rounding.round_down),
    rounding.nearest_level: _choosing(rounding.nearest_level),
    rounding.nearest_even_level: _choosing(rounding.nearest_even_level),
    rounding.two_level: lambda on, value: rounding.two_level(bool(on), 0.0),
    rounding.wrapped: _wrapped,
    rounding.nearest_integer: _counting(rounding.nearest_integer),
    int: _converting(int),
    float: _converting(float),
}
_REPLACED: dict[Any, Callable[..., Any]] = _OURS | {
    getattr(math, name): getattr(dual_math, name) for name in (*_WHOLE, *_REST)
}
_REPLACED |= {
    function: _of_one(function, _itself(slope), _itself(WIDE_SLOPES[function]))
    for function, slope in SLOPES_OF_ONE.items()
}
_REPLACED |= {function: _of_two(function, _itself(slopes)) for function, slopes in SLOPES_OF_TWO.items()}
vars(dual_math).update({name: _REPLACED[f] for name, f in vars(math).items() if callable(f) and f in SLOPES_OF_ONE})
