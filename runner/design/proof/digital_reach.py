"""Bounds of forms of a digital part in all runs: by its registers at the start, all inputs, and all
that is dropped.

Of a form only the registers count that it follows and that move at all. So an integrator that
nothing reads, or that nothing drives, takes no bound from others.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from proofmass.graphs.model.digraph import reached, turned, with_following
from proofmass.runner.design.proof.digital_map import AffineNumber, DigitalMap
from proofmass.runner.design.proof.reach import Entering, ExactRows, Extremes, Powers, extremes
from proofmass.runner.fixed.affine import ERROR, INPUT, REGISTER, AffineMantissa, AffineSymbol

_Ends = tuple[Fraction, Fraction]
_ONCE: _Ends = (Fraction(1), Fraction(1))
_NOTHING: Mapping[AffineSymbol, Fraction] = {}


@dataclass(frozen=True)
class FollowedSystem:
    """The registers that some forms follow, what enters them, and powers of their map."""

    registers: tuple[int, ...]
    symbols: tuple[AffineSymbol, ...]  # of the columns, but for the last, which is what the registers do by themselves
    entering: Entering
    powers: Powers


@dataclass(frozen=True)
class Reach:
    """Bounds of a form over all times, infinite where there are none, and how many periods before the worst enters."""

    low: float
    high: float
    system: FollowedSystem
    row: tuple[Fraction, ...]  # of the registers of the system
    periods: tuple[int, int]  # up to the lowest and the highest
    own: _Ends  # of what the form has at once


class DigitalReach:
    """Forms of a digital part: how far they get, and how far what is dropped moves them."""

    def __init__(self, of: DigitalMap) -> None:
        self._map = of
        self._ends = {AffineSymbol(INPUT, i): _ends(low, high) for i, (low, high) in enumerate(of.ranges)}
        self._ends |= {AffineSymbol(ERROR, i): (error.low, error.high) for i, error in enumerate(of.errors)}
        self._start = {AffineSymbol(REGISTER, i): Fraction(value) for i, value in enumerate(of.start)}

    def of_all(self, forms: Sequence[AffineMantissa]) -> list[Reach]:
        """Return how far forms get with all that enters, from the registers of the start."""
        return self._reach(forms, (INPUT, ERROR))

    def of_errors(self, form: AffineNumber) -> Reach | None:
        """Return how far errors alone move a form, from any registers; None where there is none."""
        return self._reach([form], (ERROR,))[0] if isinstance(form, AffineMantissa) else None

    def _reach(self, forms: Sequence[AffineMantissa], kinds: tuple[str, ...]) -> list[Reach]:
        moving = self._moving(kinds)
        groups: dict[tuple[int, ...], list[int]] = {}
        for number, form in enumerate(forms):
            groups.setdefault(self._followed(form, moving), []).append(number)
        reached: dict[int, Reach] = {}
        for registers, numbers in groups.items():
            system = self._system(registers, kinds)
            rows = [tuple(_factor(forms[n], AffineSymbol(REGISTER, r)) for r in registers) for n in numbers]
            bounds = extremes(system.powers, system.entering, rows)
            for place, number in enumerate(numbers):
                own = self._own(forms[number], kinds)
                reached[number] = _reach(bounds, place, own, system, rows[place])
        return [reached[number] for number in range(len(forms))]

    def _own(self, form: AffineMantissa, kinds: tuple[str, ...]) -> _Ends:
        """Return ends of a form's part of what enters at once, and of the start if it counts."""
        low = high = form.constant + sum((f * self._start.get(s, 0) for s, f in form.terms.items()), Fraction(0))
        if INPUT not in kinds:
            low = high = Fraction(0)
        for s, factor in form.terms.items():
            if s.kind in kinds:
                ends = [factor * end for end in self._ends[s]]
                low, high = low + min(ends), high + max(ends)
        return low, high

    def _moving(self, kinds: tuple[str, ...]) -> set[int]:
        """Return the registers that something moves: what enters, or themselves from the start."""
        by = {number: _registers(form) for number, form in enumerate(self._map.following)}
        own = {
            number
            for number, form in enumerate(self._map.following)
            if any(s.kind in kinds for s in _terms(form)) or (INPUT in kinds and self._steps[number])
        }
        return own | reached(turned(by), own)

    def _followed(self, form: AffineNumber, moving: set[int]) -> tuple[int, ...]:
        causes = with_following(
            _registers(form) & moving, lambda number: _registers(self._map.following[number]) & moving
        )
        return tuple(sorted(causes))

    @cached_property
    def _steps(self) -> list[Fraction]:
        """Moves of the registers in the first period, if nothing enters."""
        moved = []
        for number, form in enumerate(self._map.following):
            constant = form.constant if isinstance(form, AffineMantissa) else Fraction(form)
            after = constant + sum((f * self._start.get(s, 0) for s, f in _terms(form).items()), Fraction(0))
            moved.append(after - self._map.start[number])
        return moved

    def _system(self, registers: tuple[int, ...], kinds: tuple[str, ...]) -> FollowedSystem:
        following = [self._map.following[n] for n in registers]
        symbols = tuple(sorted({s for form in following for s in _terms(form) if s.kind in kinds}))
        columns: list[list[Fraction]] = [[_factor(form, s) for s in symbols] for form in following]
        ends = [self._ends[s] for s in symbols]
        if INPUT in kinds:
            columns = [[*row, self._steps[n]] for row, n in zip(columns, registers, strict=True)]
            ends.append(_ONCE)
        a: ExactRows = [[_factor(form, AffineSymbol(REGISTER, n)) for n in registers] for form in following]
        return FollowedSystem(registers, symbols, Entering(columns, ends), Powers(a))


def _reach(bounds: Extremes | None, place: int, own: _Ends, system: FollowedSystem, row: tuple[Fraction, ...]) -> Reach:
    if bounds is None:
        return Reach(-math.inf, math.inf, system, row, (0, 0), own)
    low, high = _sum(own[0], float(bounds.low[place]), -math.inf), _sum(own[1], float(bounds.high[place]), math.inf)
    return Reach(low, high, system, row, (int(bounds.low_at[place]), int(bounds.high_at[place])), own)


def _sum(own: Fraction, bound: float, way: float) -> float:
    """Return the sum of an exact number and a bound, rounded away."""
    total = own + Fraction(bound)
    rounded = float(total)
    return rounded if rounded == total else math.nextafter(rounded, way)


def _registers(form: AffineNumber) -> set[int]:
    return {s.number for s in _terms(form) if s.kind == REGISTER}


def _terms(form: AffineNumber) -> Mapping[AffineSymbol, Fraction]:
    return form.terms if isinstance(form, AffineMantissa) else _NOTHING


def _factor(form: AffineNumber, symbol: AffineSymbol) -> Fraction:
    return _terms(form).get(symbol, Fraction(0))


def _ends(low: int, high: int) -> _Ends:
    return Fraction(low), Fraction(high)
