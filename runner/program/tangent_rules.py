"""The slope of each result of an operation or an elementary function, from its operands and their slopes.

    y = f(x),  dy = f'(x) dx

What a number means for slopes is what it means for dual numbers (`derivatives.dual`). Quantisers
have the slope one: conversions to integers, `truncate`, shifts, `rounding.round_half_even`,
`rounding.round_down`, registers that wrap. What is counted with has none: `floor`, `ceiling`,
`rounding.nearest_integer`, comparisons. Bits of a number that moves have no derivative: their slope
is NaN. What is multiplied by a slope of exactly 0 is nothing, whatever it is.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

from proofmass.blocks.arithmetic import elementary, rounding
from proofmass.blocks.language import arithmetic
from proofmass.runner.derivatives.slopes import SLOPES_OF_ONE, SLOPES_OF_TWO
from proofmass.runner.program import form
from proofmass.runner.program.build import Builder
from proofmass.runner.program.lower import call
from proofmass.runner.program.lower_calls import LIBRARY
from proofmass.runner.program.structure import leaves

REST = "rest of a search"  # origin of a function of 0, part, whole and scale
NO_SLOPE = form.Immediate(form.FLOAT, 0.0)
_UNDEFINED = form.Immediate(form.FLOAT, math.nan)


class SlopeArithmetic:
    """Writes sums and products of slopes; what is known to be zero is not written."""

    def __init__(self, builder: Builder) -> None:
        self.builder, self.compute = builder, builder.compute

    def plus(self, *slopes: form.Operand) -> form.Operand:
        """Return the sum of slopes."""
        total: form.Operand = NO_SLOPE
        for slope in slopes:
            if slope is not NO_SLOPE:
                total = slope if total is NO_SLOPE else self.compute("add", total, slope)
        return total

    def minus(self, slope: form.Operand) -> form.Operand:
        """Return the slope with the other sign."""
        return NO_SLOPE if slope is NO_SLOPE else self.compute("negate", slope)

    def times(self, slope: form.Operand, factor: form.Operand | float) -> form.Operand:
        """Return a factor times a slope; nothing where the slope is 0, whatever the factor."""
        if slope is NO_SLOPE:
            return NO_SLOPE
        product = self.compute("multiply", slope, factor)
        if isinstance(factor, float | form.Immediate):
            return product
        return self.compute("select", self.compute("equal", slope, 0.0), 0.0, product)

    def over(self, slope: form.Operand, divisor: form.Operand) -> form.Operand:
        """Return a slope divided by a number."""
        return self.times(slope, self.compute("divide", 1.0, divisor))

    def chosen(self, condition: form.Operand, slope: form.Operand, other: form.Operand) -> form.Operand:
        """Return one slope or the other."""
        return self.compute("select", condition, slope, other)

    def undefined(self, *slopes: form.Operand) -> form.Operand:
        """Return no slope where all of some are 0, NaN elsewhere."""
        total = self.plus(*(self.compute("absolute", slope) for slope in slopes if slope is not NO_SLOPE))
        if total is NO_SLOPE:
            return NO_SLOPE
        return self.compute("select", self.compute("equal", total, 0.0), 0.0, _UNDEFINED)

    def number(self, value: form.Operand) -> form.Operand:
        """Return a number or an integer as a number."""
        return value if value.kind is form.FLOAT else self.compute("float_of_integer", value)


class TangentStep(NamedTuple):
    """An operation or a call in a function being written: operands, their slopes, its result."""

    slopes: SlopeArithmetic
    beside: Sequence[form.Storage]  # arrays that rules may use
    x: Sequence[Any]
    dx: Sequence[form.Operand]
    y: form.Operand

    @property
    def builder(self) -> Builder:
        """Builder of the function."""
        return self.slopes.builder

    def numbers(self) -> list[form.Operand]:
        """Return the operands as numbers."""
        return [self.slopes.number(value) for value in self.x]


TangentRule: TypeAlias = Callable[[TangentStep], form.Operand]  # gives the slope of the result


def origin_of(function: Callable[..., Any]) -> str:
    """Return the origin that a function of Python has in programs."""
    return f"{function.__module__}.{function.__qualname__}"


def _nothing(s: TangentStep) -> form.Operand:
    return NO_SLOPE


def _same(s: TangentStep) -> form.Operand:
    return s.dx[0]


def _unknown(s: TangentStep) -> form.Operand:
    return s.slopes.undefined(*s.dx)


def _sum(s: TangentStep) -> form.Operand:
    return s.slopes.plus(*s.dx)


def _difference(s: TangentStep) -> form.Operand:
    return s.slopes.plus(s.dx[0], s.slopes.minus(s.dx[1]))


def _product(s: TangentStep) -> form.Operand:
    slopes, (a, b) = s.slopes, s.numbers()
    return slopes.plus(slopes.times(s.dx[0], b), slopes.times(s.dx[1], a))


def _quotient(s: TangentStep) -> form.Operand:
    slopes, (a, b) = s.slopes, s.numbers()
    turned = slopes.times(slopes.minus(s.dx[1]), slopes.compute("divide", a, b))
    return slopes.plus(slopes.over(s.dx[0], b), slopes.over(turned, b))


def _remainder(s: TangentStep) -> form.Operand:
    slopes = s.slopes
    turns = slopes.number(slopes.compute("floor_divide", *s.x))
    return slopes.plus(s.dx[0], slopes.minus(slopes.times(s.dx[1], turns)))


def _left_over(s: TangentStep) -> form.Operand:
    slopes = s.slopes
    turns = slopes.compute("truncate", slopes.compute("divide", *s.x))
    return slopes.plus(s.dx[0], slopes.minus(slopes.times(s.dx[1], turns)))


def _rest(s: TangentStep) -> form.Operand:
    """Return the slope of scale part / whole, of which the value counts as 0; without a whole there is none."""
    slopes, (_, part, whole, scale), (_, *of_ratio, by_scale) = s.slopes, s.numbers(), s.dx
    ratio = slopes.times(_quotient(s._replace(x=(part, whole), dx=of_ratio)), scale)
    slope = slopes.plus(ratio, slopes.times(by_scale, slopes.compute("divide", part, whole)))
    return slope if slope is NO_SLOPE else slopes.chosen(slopes.compute("equal", whole, 0.0), NO_SLOPE, slope)


def _size(s: TangentStep) -> form.Operand:
    slopes, compute = s.slopes, s.slopes.compute
    sided = slopes.chosen(compute("less", s.x[0], 0.0), slopes.minus(s.dx[0]), s.dx[0])
    return slopes.chosen(compute("equal", s.x[0], 0.0), slopes.undefined(s.dx[0]), sided)


def _signed(s: TangentStep) -> form.Operand:
    slopes = s.slopes
    return slopes.chosen(slopes.compute("equal", s.x[0], s.y), s.dx[0], slopes.minus(s.dx[0]))


def masked(apart: TangentRule) -> TangentRule:
    """Return the rule of bits that both have, by that of a number which is taken apart."""

    def rule(s: TangentStep) -> form.Operand:
        """Return the slope of all bits, or of the low ones, as in a register that wraps. A parity is compared."""
        for mask, slope in ((_integer(s.x[1]), s.dx[0]), (_integer(s.x[0]), s.dx[1])):
            if mask == 1:
                return NO_SLOPE
            if mask >= -1 and mask and not mask & mask + 1:
                return slope
        return apart(s)

    return rule


def _turned(s: TangentStep) -> form.Operand:
    """Return the slope with all bits turned, or the highest of a register that wraps, which is subtracted again."""
    for mask, slope in ((_integer(s.x[1]), s.dx[0]), (_integer(s.x[0]), s.dx[1])):
        if mask == -1:
            return s.slopes.minus(slope)
        if mask > 0 and not mask & mask - 1:
            return slope
    return s.slopes.undefined(*s.dx)


def _integer(value: form.Operand) -> int:
    """Return an integer that the program knows; 0, which takes all bits, for any other."""
    return int(value.value) if isinstance(value, form.Immediate) else 0


def _raised(s: TangentStep) -> form.Operand:
    slopes = s.slopes
    return slopes.plus(slopes.times(s.dx[0], _scale(s)), slopes.undefined(s.dx[1]))


def _lowered(s: TangentStep) -> form.Operand:
    slopes = s.slopes
    return slopes.plus(slopes.over(s.dx[0], _scale(s)), slopes.undefined(s.dx[1]))


def _scale(s: TangentStep) -> form.Operand:
    return s.slopes.number(s.slopes.compute("shift_left", 1, s.x[1]))


OF_OPERATIONS: dict[str, TangentRule] = {
    **{name: _nothing for name, signature in form.OPERATIONS.items() if signature.result is form.TRUTH},
    **dict.fromkeys(("floor", "ceiling", "integer_of_truth", "float_of_truth"), _nothing),
    **dict.fromkeys(("truncate", "round_half_even", "float_of_integer", "integer_of_float"), _same),
    **dict.fromkeys(("or", "bits_of_float", "float_of_bits"), _unknown),
    **dict.fromkeys(("add", "add_integers"), _sum),
    **dict.fromkeys(("subtract", "subtract_integers"), _difference),
    **dict.fromkeys(("multiply", "multiply_integers"), _product),
    **dict.fromkeys(("divide", "floor_divide"), _quotient),
    "modulo": _remainder,
    "negate": lambda s: s.slopes.minus(s.dx[0]),
    "absolute": _size,
    "copy_sign": _signed,
    "square_root": lambda s: s.slopes.times(s.dx[0], s.slopes.compute("divide", 0.5, s.y)),
    "and": masked(_unknown),
    "xor": _turned,
    "shift_left": _raised,
    "shift_right": _lowered,
    "select": lambda s: s.slopes.chosen(s.x[0], s.dx[1], s.dx[2]),
}


def _chain(slopes_of: Callable[..., Any]) -> TangentRule:
    """Return the chain rule for derivatives that are functions of Python."""

    def rule(s: TangentStep) -> form.Operand:
        slopes, library = s.slopes, LIBRARY.get(slopes_of)
        if all(slope is NO_SLOPE for slope in s.dx):
            return NO_SLOPE
        made = slopes.builder.call(library, *s.x) if library else leaves((call(slopes.builder, slopes_of, s.x),))
        factors = [each for each in made if not isinstance(each, form.Storage)]
        return slopes.plus(*(slopes.times(slope, factor) for slope, factor in zip(s.dx, factors, strict=True)))

    return rule


def within_levels(s: TangentStep) -> form.Operand:
    """Return the slope of what is held between 0 and the last level."""
    slopes, compute = s.slopes, s.builder.compute
    value, last = s.numbers()
    above = slopes.chosen(compute("less", 0.0, value), s.dx[0], NO_SLOPE)
    return slopes.chosen(compute("less", value, last), above, s.dx[1])


OF_FUNCTIONS: dict[str, TangentRule] = {
    **{origin_of(function): _chain(slope) for function, slope in SLOPES_OF_ONE.items() if function not in LIBRARY},
    **{LIBRARY[function].symbol: _chain(slope) for function, slope in SLOPES_OF_ONE.items() if function in LIBRARY},
    **{origin_of(function): _chain(slopes) for function, slopes in SLOPES_OF_TWO.items()},
    "atan2": _chain(SLOPES_OF_TWO[elementary.arctangent2]),
    "pow": _chain(SLOPES_OF_TWO[elementary.power]),
    "fmod": _left_over,
    REST: _rest,
    origin_of(rounding.round_half_even): _same,
    origin_of(rounding.round_down): _same,
    origin_of(rounding.nearest_level): within_levels,
    origin_of(rounding.nearest_even_level): within_levels,
    origin_of(rounding.wrapped): _same,
    origin_of(rounding.nearest_integer): _nothing,
    origin_of(arithmetic.number_floor_divide): _quotient,
}
