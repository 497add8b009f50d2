"""Mantissas as affine forms: what a digital block computes, for all inputs at once, with every bit that it drops.

    mantissa = constant + sum of factor_s s,   s: registers, inputs, and one error for each place where bits are dropped

Factors are exact. Each error lies between bounds that are read off its rule of rounding. Where a
step decides, as at the end of a range, it goes the way of the start, and a condition is noted that
the form has to keep for that. So the forms are those of the step in all states and for all inputs
that keep the conditions, not only near the start. What is neither affine nor decided by conditions
raises `NotAffineError`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import gcd
from typing import Any, NamedTuple

from proofmass.blocks.arithmetic.mantissa import Mantissa

_LARGE = 200  # bits of a number by which a rule shows how many bits it drops


class NotAffineError(ArithmeticError):
    """A step does more with a number than add, scale, round and limit it."""


class AffineSymbol(NamedTuple):
    """One term of forms: a register at the start of a period, an input, or an error."""

    kind: str  # REGISTER, INPUT or ERROR
    number: int


REGISTER, INPUT, ERROR = "register", "input", "error"


@dataclass(frozen=True)
class RoundingError:
    """Error of a place that drops bits, in steps of its result."""

    at: str  # the function, "filter.update"
    low: Fraction
    high: Fraction


@dataclass(frozen=True)
class FormBounds:
    """Bounds of a form, in steps, without which another form would follow; None without."""

    form: "AffineMantissa"
    low: int | None
    high: int | None
    at: str


@dataclass
class AffineForms:
    """Conditions and errors that forms have in common, and where the step is."""

    start: dict[AffineSymbol, Fraction] = field(
        default_factory=dict
    )  # values that decide; what is not here counts as 0
    at: str = ""
    errors: list[RoundingError] = field(default_factory=list)
    _kept: dict[Any, FormBounds] = field(default_factory=dict)
    _rounded: dict[Any, Any] = field(default_factory=dict)

    def symbol(self, kind: str, number: int, start: Fraction = Fraction(0)) -> "AffineMantissa":
        """Return a symbol as a mantissa."""
        self.start[AffineSymbol(kind, number)] = start
        return AffineMantissa(self, {AffineSymbol(kind, number): Fraction(1)}, Fraction(0), 1)

    def keeps(self, form: "AffineMantissa", low: int | None, high: int | None) -> None:
        """Note a condition, together with others of its form or a constant apart."""
        key = frozenset(form.terms.items())
        before = self._kept.get(key, FormBounds(form, None, None, self.at))
        apart = int(before.form.constant - form.constant)
        lows = [end for end in (before.low, None if low is None else low + apart) if end is not None]
        highs = [end for end in (before.high, None if high is None else high + apart) if end is not None]
        self._kept[key] = replace(before, low=max(lows, default=None), high=min(highs, default=None))

    @property
    def conditions(self) -> tuple[FormBounds, ...]:
        """All conditions, one of each form."""
        return tuple(self._kept.values())

    def rounded(self, form: "AffineMantissa", rule: Callable[[int], int], parts: int) -> Any:
        """Return form / parts as a rule rounds it; the same number rounds alike everywhere."""
        step = gcd(form.multiple, parts)  # of the values that the form has
        exact = form.scaled(Fraction(1, parts), form.multiple // step)
        if step == parts:
            return exact
        errors = _errors(rule, parts, step)
        key = (frozenset(form.terms.items()), form.constant, parts, errors)
        if key not in self._rounded:
            self.errors.append(RoundingError(self.at, min(errors), max(errors)))
            error = self.symbol(ERROR, len(self.errors) - 1)
            whole = exact + error if isinstance(exact, AffineMantissa) else error
            self._rounded[key] = AffineMantissa(self, whole.terms, whole.constant, 1)
        return self._rounded[key]


class AffineMantissa(Mantissa):
    """A `Mantissa` that stands for an affine form; a whole number of `multiple`."""

    __slots__ = ("constant", "multiple", "of", "terms")
    __hash__ = None  # type: ignore[assignment]

    def __init__(
        self, of: AffineForms, terms: Mapping[AffineSymbol, Fraction], constant: Fraction, multiple: int
    ) -> None:
        self.of, self.terms, self.constant, self.multiple = of, terms, constant, multiple

    def __repr__(self) -> str:
        terms = "".join(f" + {factor} {s.kind} {s.number}" for s, factor in self.terms.items())
        return f"{self.constant}{terms}"

    @property
    def copies(self) -> bool:
        """True if it is a register or an input as it is."""
        return not self.constant and [*self.terms.values()] == [1]

    def at_start(self) -> Fraction:
        """Return the value at the start."""
        return self.constant + sum(factor * self.of.start.get(s, 0) for s, factor in self.terms.items())

    def scaled(self, factor: Fraction, multiple: int) -> "AffineMantissa":
        """Return the form times a number, whose values are known to be multiples of another."""
        terms = {s: factor * of_s for s, of_s in self.terms.items()}
        return AffineMantissa(self.of, terms, factor * self.constant, multiple)

    def __add__(self, other: Any) -> Any:
        if isinstance(other, int):
            return AffineMantissa(self.of, self.terms, self.constant + other, gcd(self.multiple, other))
        if not isinstance(other, AffineMantissa):
            return NotImplemented
        terms = dict(self.terms)
        for s, factor in other.terms.items():
            terms[s] = terms.get(s, Fraction(0)) + factor
            if not terms[s]:
                del terms[s]
        constant = self.constant + other.constant
        multiple = gcd(self.multiple, other.multiple)
        return AffineMantissa(self.of, terms, constant, multiple) if terms else int(constant)

    __radd__ = __add__

    def __neg__(self) -> "AffineMantissa":
        return self.scaled(Fraction(-1), self.multiple)

    def __sub__(self, other: Any) -> Any:
        return self + -other if isinstance(other, int | AffineMantissa) else NotImplemented

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, AffineMantissa):
            raise NotAffineError("a product of two signals")
        if not isinstance(other, int):
            return NotImplemented
        return self.scaled(Fraction(other), self.multiple * abs(other)) if other else 0

    __rmul__ = __mul__

    def __lshift__(self, places: Any) -> Any:
        return self * (1 << _known(places))

    def __rshift__(self, places: Any) -> Any:
        return self.of.rounded(self, lambda whole: whole >> places, 1 << _known(places))

    def __rlshift__(self, other: Any) -> Any:
        raise NotAffineError("a shift by a signal")

    __rrshift__ = __rlshift__

    def __floordiv__(self, other: Any) -> Any:
        raise NotAffineError("a division")

    __rfloordiv__ = __mod__ = __rmod__ = __truediv__ = __rtruediv__ = __floordiv__

    def __and__(self, mask: Any) -> Any:
        return self if _all_bits(mask) else 0

    def __or__(self, mask: Any) -> Any:
        return -1 if _all_bits(mask) else self

    def __xor__(self, mask: Any) -> Any:
        return ~self if _all_bits(mask) else self

    __rand__, __ror__, __rxor__ = __and__, __or__, __xor__

    # -- decisions: those of the start, with the condition under which they are the same -----------

    def _below(self, other: Any, by: int) -> bool:
        """Return whether self <= other - by."""
        if not isinstance(other, int):
            apart = self - other
            return apart <= -by if isinstance(apart, int) else apart._below(0, by)
        below = self.at_start() <= other - by
        self.of.keeps(self, *((None, other - by) if below else (other - by + 1, None)))
        return below

    def __lt__(self, other: Any) -> bool:
        return self._below(other, 1)

    def __le__(self, other: Any) -> bool:
        return self._below(other, 0)

    def __gt__(self, other: Any) -> bool:
        return not self._below(other, 0)

    def __ge__(self, other: Any) -> bool:
        return not self._below(other, 1)

    def __eq__(self, other: object) -> bool:
        apart = self - other if isinstance(other, int | AffineMantissa) else NotImplemented
        if not isinstance(apart, AffineMantissa):
            return apart == 0 if isinstance(apart, int) else apart
        start = apart.at_start()
        self.of.keeps(apart, *((0, 0) if start == 0 else (1, None) if start > 0 else (None, -1)))
        return bool(start == 0)

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __bool__(self) -> bool:
        return self != 0

    def __abs__(self) -> Any:
        return -self if self < 0 else self

    def __index__(self) -> int:
        raise NotAffineError("a signal bounds a loop or indexes a list")

    __int__ = __index__

    # -- what a mantissa does in a way of its own --------------------------------------------------

    def monotone(self, rule: Callable[[Any], Any]) -> Any:
        """The form divided by the power of two that the rule shows, and an error."""
        return self.of.rounded(self, rule, (1 << _LARGE) // rule(1 << _LARGE))

    def held(self, low: int, high: int, expected: str) -> "AffineMantissa":
        """The form itself, which has to lie in the range."""
        self.of.keeps(self, low, high)
        return self

    def wrapped(self, low: int, high: int) -> Any:
        """The form less the whole turns that it has at the start."""
        turns = int((self.at_start() - low) // (high - low + 1)) * (high - low + 1)
        self.of.keeps(self, low + turns, high + turns)
        return self - turns


def _errors(rule: Callable[[int], int], parts: int, step: int) -> tuple[Fraction, ...]:
    """Return what a rule adds to multiples of `step`, where it may be the most or the least.

    An error grows by -step / parts from one multiple to the next, but where the rule steps up: at a
    whole number or a half, on both sides of zero.
    """
    multiples = parts // step
    near = {whole + part for whole in range(-2 * multiples, 2 * multiples, multiples) for part in _parts(multiples)}
    return tuple(rule(step * m) - Fraction(m, multiples) for m in sorted(near))


def _parts(multiples: int) -> set[int]:
    half = multiples // 2
    return {part for place in (0, half, multiples) for part in (place - 1, place, place + 1)}


def _known(places: Any) -> int:
    if not isinstance(places, int):
        raise NotAffineError("a shift by a signal")
    return places


def _all_bits(mask: Any) -> bool:
    """Return whether a mask has all bits, not none; any other takes a number apart."""
    if not isinstance(mask, int) or mask not in (0, -1):
        raise NotAffineError("an operation on the bits of a signal")
    return mask == -1
