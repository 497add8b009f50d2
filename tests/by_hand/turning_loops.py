"""Random loops that repeat after a period, and their margins from the graph's numbers; nothing of the product counts.

Each part is a list of small matrices, one for each tick of its period. A period of the loop is multiplied from them row
by row in balls of 512 bits, as what it does to the memory and to the values of the wire (lifting). Where one quotient
L = N / D decides, its truth is that of `polynomial_loops`. Else the poles of the period are followed over a dense grid
of factors and turns, and each crossing is solved for in 80 digits.
"""

import itertools
import math
import random
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

import flint
import mpmath
import numpy as np
import numpy.typing as npt
import scipy.optimize

from proofmass.blocks import (
    ChopperModulator,
    Constant,
    Decimator,
    Delay,
    Difference,
    DiscreteTransferFunction,
    Gain,
    MovingAverage,
    Product,
    RepeatingSequence,
    Sine,
    SynchronousDemodulator,
    TransferFunction,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.graphs.model.build import Graph
from tests.by_hand.polynomial_loops import DIGITS, Line, Truth, roots_of, truth_of_quotient

BITS = 512
MOST_DELAYED = 200  # samples
_PLACES = 120  # of a decade of factors, and of a quarter of a turn
_LAST = 9.0  # decades
_FAR = 1e-12
_optimize: Any = scipy.optimize
_ON_THE_BOUNDARY = 1e-11
_ANOTHER = 10_000_000
Matrix = list[list[Any]]
Array = npt.NDArray[Any]


class Tick(NamedTuple):
    """x' = a x + b u, y = c x + d u in one tick."""

    a: Matrix
    b: list[Any]
    c: list[Any]
    d: Any


class Part(NamedTuple):
    """Blocks of a chain with the wires between them, where it begins and ends, and its ticks in base ticks."""

    blocks: dict[str, tuple[Block, int]]  # and after how many base ticks each ticks
    wires: list[str]
    entry: str
    exit: str
    ticks: list[Tick]


class Counted(Block):
    """Passes its input on, more in each tick in which a counter of its own begins anew."""

    length: int = param("1", "Ticks of the counter.", default=4, at_least=2, at_most=2000)
    more: float = param("1", "Further gain when it begins anew.", default=1.0)

    input = Input("1", "Signal.")


class Count(NamedTuple):
    """Ticks since the counter began anew."""

    ticks: int


@Counted.output("1")
def passed(p: Counted, x: Count, input: float) -> float:
    """The signal, with more gain in some ticks."""
    return input + p.more * input if x.ticks == 0 else input


@Counted.update
def count_on(p: Counted, x: Count) -> Count:
    return Count(x.ticks + 1 if x.ticks + 1 < p.length else 0)


class Twice(Block):
    """Delay by a ring whose place moves by two cells a tick, so that it is back after half as many as it has."""

    input = Input("1", "Signal to delay.")

    line = Buffer("Two cells for each place.", float, (6,))


class Place(NamedTuple):
    """The first cell of the place."""

    cell: int


@Twice.output("1")
def late(p: Twice, x: Place, line: list[float]) -> float:
    """The mean of the inputs two and three ticks before."""
    return 0.5 * (line[x.cell] + line[(x.cell + 3) % 6])


@Twice.update
def turn(p: Twice, x: Place, line: list[float], input: float) -> Place:
    line[x.cell] = input
    line[x.cell + 1] = input
    return Place((x.cell + 2) % 6)


def turning_loop(number: int, longest: int = 12) -> tuple[Graph, Truth]:
    """Return a loop whose period has several values of its wire, or one, and what it has.

    Each period is `longest` at most where the wire has a value in every tick; at a slow wire it may be 1,023. Loops
    with a pole on the boundary of stability are left out.
    """
    for again in itertools.count():
        graph, lifted = drawn(number + again * _ANOTHER, longest)
        truth = lifted.truth()
        if abs(truth.outside) > _ON_THE_BOUNDARY:
            return graph, truth
    raise AssertionError


def drawn(number: int, longest: int = 12) -> tuple[Graph, "Lifted"]:
    """Return a random loop and its period."""
    flint.ctx.prec = BITS
    dice = random.Random(number)
    rate = float(dice.choice([1, 7, 100, 1000, 1024, 50_000]))
    slow_wire = dice.random() < 0.4
    period = _period(
        dice, longest if not slow_wire else dice.choice([6, 12] if longest < 12 else [6, 12, 40, 40, 120, 1023])
    )
    divisors = [d for d in range(1, period + 1) if period % d == 0]
    divisors = [d for d in divisors if d == 1 or d <= 32] or [1]
    wire = period if slow_wire else dice.choice([1, 1, *[d for d in divisors if period // d > 1]])
    parts = [_register(dice, wire)]
    for _ in range(dice.randint(1, 2)):
        parts += _turning(dice, period, divisors, rate)
    if dice.random() < 0.3:
        parts += [_gain(1.0, 1), _plant(dice, rate)]
    if dice.random() < 0.6:
        parts.append(_register(dice, dice.choice(divisors)))
    parts.append(_slow(dice, wire))
    gain = dice.choice([1.0, 1.0, 1.0, -1.0]) * 10.0 ** dice.uniform(-2.0, 0.3)
    parts.insert(0, _gain(gain, wire))
    return _graph(number, rate, parts, wire), Lifted.of(parts, wire, rate)


def _period(dice: random.Random, longest: int) -> int:
    return longest if longest > 12 else dice.randint(2, longest)


def _turning(dice: random.Random, period: int, divisors: Sequence[int], rate: float) -> list[Part]:
    """Return what changes from tick to tick, and what lies between two of it."""
    match dice.randint(0, 6):
        case 0 if period % 2 == 0:
            half = period // 2
            return [_chopper(half), _slow(dice, 1), _chopper(half)]
        case 1:
            turns = dice.randint(1, max(1, (period - 1) // 2))
            carrier = [_carrier(turns, period, rate, dice.uniform(0.0, 6.0)) for _ in range(2)]
            return [carrier[0], _slow(dice, 1), carrier[1]]
        case 2:
            return [_sequence([round(dice.uniform(-1.0, 2.0), 3) for _ in range(period)])]
        case 3:
            return [_counted(period, dice.uniform(-1.5, 3.0))]
        case 4:
            return [_decimator(period)]
        case 5 if period > 2:
            return _demodulated(dice, period, rate)
        case _:
            return [_slow(dice, dice.choice(divisors)), _counted(period, 0.5)]


def _every(divisor: int, tick: Tick) -> list[Tick]:
    """Return a block that ticks once in so many base ticks and holds its output in between, by a further state."""
    n = len(tick.b)
    zero, one = flint.arb(0), flint.arb(1)
    if divisor == 1:
        return [tick]
    moves = Tick([*[[*row, zero] for row in tick.a], [*tick.c, zero]], [*tick.b, tick.d], [*tick.c, zero], tick.d)
    eye = [[one if i == j else zero for j in range(n + 1)] for i in range(n + 1)]
    waits = Tick(eye, [zero] * (n + 1), [*([zero] * n), one], zero)
    return [moves, *([waits] * (divisor - 1))]


def _single(block: Block, output: str, divisor: int, tick: Tick) -> Part:
    return Part({"": (block, divisor)}, [], ".input", f".{output}", _every(divisor, tick))


def _gain(gain: float, divisor: int) -> Part:
    return _single(Gain(gain=gain), "output", divisor, Tick([], [], [], flint.arb(gain)))


def _register(dice: random.Random, divisor: int) -> Part:
    """Return a delay of some kind, which never passes anything on in the same tick."""
    length = dice.choice([1, 2, 3, 5])
    match dice.randint(0, 4):
        case 0:
            return _single(UnitDelay(), "output", divisor, _shift([0, 1]))
        case 1:
            return _single(Delay(ticks=length), "output", divisor, _shift([0] * length + [1]))
        case 2:
            return _single(Line(ticks=length), "output", divisor, _shift([0] * length + [1]))
        case 3:
            return _single(Twice(), "late", divisor, _shift([0, 0, flint.arb(0.5), flint.arb(0.5)]))
        case _:
            return _single(DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, -0.25)), *_pole(0.25, divisor))


def _pole(pole: float, divisor: int) -> tuple[str, int, Tick]:
    arb = flint.arb
    return "strictly_proper_part", divisor, Tick([[arb(pole)]], [arb(1)], [arb(1)], arb(0))


def _shift(taps: Sequence[Any]) -> Tick:
    """Return the shift register of a finite response, the newest input first."""
    n = len(taps) - 1
    arb = flint.arb
    a = [[arb(int(i == j + 1)) for j in range(n)] for i in range(n)]
    return Tick(a, [arb(int(i == 0)) for i in range(n)], [arb(tap) for tap in taps[1:]], arb(taps[0]))


def _slow(dice: random.Random, divisor: int) -> Part:
    """Return an integrator, or a pole as close to 1 as 1e-9, a mean, or a pole that turns."""
    arb = flint.arb
    kind = dice.random()
    if kind < 0.15:
        length = dice.randint(2, 4)
        share = arb(1) / length
        return _single(MovingAverage(length=length), "mean", divisor, _shift([share] * length))
    if kind < 0.3:
        size, angle = 1.0 - 10.0 ** dice.uniform(-4.0, -0.5), dice.uniform(0.1, 3.0)
        low, high = -2.0 * size * math.cos(angle), size * size
        block = DiscreteTransferFunction(numerator=(0.1, 0.05), denominator=(1.0, low, high))
        a = [[arb(-low), arb(-high)], [arb(1), arb(0)]]
        tick = Tick(a, [arb(1), arb(0)], [arb(0.1), arb(0.05)], arb(0))
        return _single(block, "strictly_proper_part", divisor, tick)
    pole = dice.choice([1.0, 1.0 - 10.0 ** dice.uniform(-9.0, -0.3)])
    gain = 10.0 ** dice.uniform(-3.0, -0.3)
    block = DiscreteTransferFunction(numerator=(gain,), denominator=(1.0, -pole))
    return _single(block, "strictly_proper_part", divisor, Tick([[arb(pole)]], [arb(1)], [arb(gain)], arb(0)))


def _plant(dice: random.Random, rate: float) -> Part:
    """Return a lag or a resonator in continuous time, whose input is held; k / s too."""
    w = rate * 10.0 ** dice.uniform(-2.0, 0.0)
    with mpmath.workdps(DIGITS):
        match dice.randint(0, 2):
            case 0:
                numerator, denominator = [w], [1.0, 0.0]
            case 1:
                numerator, denominator = [w], [1.0, w]
            case _:
                numerator, denominator = [w * dice.uniform(0.1, 1.0), w * w], [1.0, w / 5.0, w * w]
        n = len(denominator) - 1
        whole = mpmath.zeros(n + 1)
        for i in range(n):
            whole[0, i] = -mpmath.mpf(denominator[i + 1])
            if i:
                whole[i, i - 1] = 1
        whole[0, n] = 1
        moved = mpmath.expm(whole / mpmath.mpf(rate))
        rows = [[_ball(moved[i, j]) for j in range(n + 1)] for i in range(n)]
    c = [flint.arb(value) for value in [0.0] * (n - len(numerator)) + numerator]
    tick = Tick([row[:n] for row in rows], [row[n] for row in rows], c, flint.arb(0))
    block = TransferFunction(numerator=tuple(numerator), denominator=tuple(denominator))
    return Part({"": (block, 0)}, [], ".input", ".strictly_proper_part", [tick])


def _ball(value: Any) -> Any:
    sign, mantissa, exponent, _ = mpmath.mpf(value)._mpf_
    return flint.arb(-int(mantissa) if sign else int(mantissa)) * flint.arb(2) ** exponent


def _times(values: Sequence[Any]) -> list[Tick]:
    return [Tick([], [], [], value) for value in values]


def _chopper(half: int) -> Part:
    values = [flint.arb(1)] * half + [flint.arb(-1)] * half
    return Part({"": (ChopperModulator(half_period=half, unit="1"), 1)}, [], ".input", ".output", _times(values))


def _sequence(values: Sequence[float]) -> Part:
    blocks = {"": (Product(), 1), "values": (RepeatingSequence(values=tuple(values)), 1)}
    return Part(
        blocks, ["values.output -> .second"], ".first", ".output", _times([flint.arb(value) for value in values])
    )


def _counted(length: int, more: float) -> Part:
    values = [1 + flint.arb(more), *([flint.arb(1)] * (length - 1))]
    return Part({"": (Counted(length=length, more=more), 1)}, [], ".input", ".passed", _times(values))


def _carrier(turns: int, period: int, rate: float, phase: float) -> Part:
    """Return a product with a sine that has so many periods in so many ticks."""
    frequency = float(Fraction(turns) * Fraction(rate) / period)
    sine = Sine(frequency=frequency, phase=phase, amplitude=1.0)
    blocks = {"": (Product(), 1), "sine": (sine, 1)}
    values = _waves(turns, period, phase)
    return Part(blocks, ["sine.output -> .second"], ".first", ".output", _times(values))


def _waves(turns: int, period: int, phase: float) -> list[Any]:
    angles = [2 * flint.arb.pi() * turns * t / period + flint.arb(phase) for t in range(period)]
    return [angle.sin() for angle in angles]


def _decimator(ratio: int) -> Part:
    """Return a mean over windows, that is given in the tick after: a sum and a held mean."""
    return Part({"": (Decimator(ratio=ratio), 1)}, [], ".input", ".mean", _windows([flint.arb(1) / ratio] * ratio))


def _windows(weights: Sequence[Any]) -> list[Tick]:
    """Return a weighted sum over windows that is held over the next."""
    zero, one = flint.arb(0), flint.arb(1)
    ticks = [Tick([[one, zero], [zero, one]], [weight, zero], [zero, one], zero) for weight in weights[:-1]]
    last = weights[-1]
    return [*ticks, Tick([[zero, zero], [one, zero]], [zero, last], [zero, one], zero)]


def _demodulated(dice: random.Random, period: int, rate: float) -> list[Part]:
    """Return a modulator and the demodulator that takes its carrier off again."""
    turns = dice.randint(1, (period - 1) // 2)
    frequency = float(Fraction(turns) * Fraction(rate) / period)
    phase = dice.uniform(0.0, 1.0)
    blocks: dict[str, tuple[Block, int]] = {
        "": (SynchronousDemodulator(ratio=period, unit="1"), 1),
        "sine": (Sine(frequency=frequency, phase=phase), 1),
        "cosine": (Sine(frequency=frequency, phase=phase + 0.5 * math.pi), 1),
    }
    wires = ["sine.output -> .sine", "cosine.output -> .cosine"]
    weights = [2 * value / period for value in _waves(turns, period, phase)]
    demodulator = Part(blocks, wires, ".signal", ".in_phase", _windows(weights))
    return [_carrier(turns, period, rate, dice.uniform(-0.5, 0.5)), demodulator]


def _graph(number: int, rate: float, parts: Sequence[Part], wire: int) -> Graph:
    base = Fraction(rate)
    blocks: dict[str, Block] = {"zero": Constant(value=0.0), "error": Difference()}
    rates = {"zero": base / wire, "error": base / wire}
    wires, last = ["zero.output -> error.first"], "error.output"
    for i, part in enumerate(parts):

        def named(place: str, i: int = i) -> str:
            block, _, port = place.partition(".")
            return f"part_{i}{'_' if block else ''}{block}.{port}"

        for name, (block, divisor) in part.blocks.items():
            full = named(f"{name}.").rstrip(".")
            blocks[full] = block
            if divisor:
                rates[full] = base / divisor
        for one in part.wires:
            source, target = one.split(" -> ")
            wires.append(f"{named(source)} -> {named(target)}")
        wires.append(f"{last} -> {named(part.entry)}")
        last = named(part.exit)
    wires.append(f"{last} -> error.second")
    return Graph(
        name=f"turning loop {number}",
        rate=base,
        rates=rates,
        blocks=blocks,
        wires=wires,
        loops={"main": {"open_at": last}},
    )


class Lifted:
    """L of a period: what it does to the memory and the values of the wire, and how often these come."""

    def __init__(self, whole: tuple[Array, Array, Array, Array], period: float) -> None:
        """Take A, B, C and D in balls."""
        self.whole, self.period = whole, period
        self.near = tuple(_doubles(part) for part in whole)
        self.values = len(whole[3])

    @classmethod
    def of(cls, parts: Sequence[Part], wire: int, rate: float) -> "Lifted":
        """Return the period of a chain in feedback, with a value of the wire in every so many ticks."""
        flint.ctx.prec = BITS
        ticks = math.lcm(wire, *(len(part.ticks) for part in parts))
        sizes = [len(part.ticks[0].b) for part in parts]
        n, values = sum(sizes), ticks // wire
        zero, one = flint.arb(0), flint.arb(1)
        rows = np.array([[one if i == j else zero for j in range(n + values)] for i in range(n)], dtype=object)
        rows = rows.reshape(n, n + values)
        read = []
        for t in range(ticks):
            signal = np.array([one if j == n + t // wire else zero for j in range(n + values)], dtype=object)
            first = 0
            for part, size in zip(parts, sizes, strict=True):
                tick, own = part.ticks[t % len(part.ticks)], rows[first : first + size]
                moved = [_sum(tick.a[i], own) + tick.b[i] * signal for i in range(size)]
                signal = _sum(tick.c, own) + tick.d * signal
                for i, row in enumerate(moved):
                    rows[first + i] = row
                first += size
            if t % wire == 0:
                read.append(signal)
        out = np.array(read, dtype=object)
        return cls((rows[:, :n], rows[:, n:], out[:, :n], out[:, n:]), ticks / rate)

    def truth(self) -> Truth:
        """Return everything."""
        quotient = self._quotient()
        if quotient is not None:
            with mpmath.workdps(DIGITS):
                found = truth_of_quotient(*quotient, 1.0 / self.period)
            if self.values > 1:  # S and T of one number, or of all values: the peaks of either are right
                found = found._replace(
                    delay_margin=self._delay_margin(), disk_margin=math.nan, sensitivity_peak=math.nan
                )
            return found
        outside = self._outside(1.0)
        gains = self._stable_gains()
        stable = outside < 0.0
        low, high = next(((a, b) for a, b in gains if a < 1.0 < b), (0.0, math.inf))
        return Truth(
            outside,
            high if stable and math.isfinite(high) else None,
            (low or None) if stable else None,
            self._turn() if stable else None,
            self._delay_margin() if stable else None,
            1.0 / self._peak(0.5) if stable else math.nan,
            self._peak(1.0) if stable else math.nan,
            gains,
        )

    def _quotient(self) -> tuple[list[Any], list[Any]] | None:
        """Return N and D of the L that decides if the values that are read or given count through one number alone."""
        a, b, c, d = self.whole
        answers = [d]
        for _ in a:
            answers.append(c @ b)
            b = a @ b
        b = self.whole[1]
        place = _one_number(np.vstack(answers))
        if place is not None:
            row, j = place
            into, out, direct = b[:, j] / row[j], row @ c, row @ d[:, j] / row[j]
        else:
            place = _one_number(np.hstack(answers).T)
            if place is None:
                return None
            row, j = place
            into, out, direct = b @ row, c[j] / row[j], d[j] @ row / row[j]
        open_poles, less = _characteristic(a), _characteristic(a - np.outer(into, out))
        top = [one - other for one, other in zip(less, open_poles, strict=True)]
        top = [value + direct * below for value, below in zip(top, open_poles, strict=True)]
        return [_number(value) for value in top], [_number(value) for value in open_poles]

    def _closed(self, factors: Array) -> Array:
        a, b, c, d = self.near
        gain = np.eye(self.values) + factors[:, None, None] * d
        back = np.linalg.solve(gain, np.broadcast_to(c, (len(gain), *c.shape)))
        return np.asarray(a - factors[:, None, None] * (b @ back))

    def _sizes(self, factors: Array) -> Array:
        return np.asarray(np.max(np.abs(np.linalg.eigvals(self._closed(factors))), axis=1) - 1.0)

    def _outside(self, factor: float) -> float:
        """Return by how much the slowest pole of the period lies outside, in many digits."""
        a, b, c, d = self.whole
        times = flint.arb(factor)
        gain = flint.arb_mat((np.eye(self.values, dtype=int) + times * d).tolist())
        back = gain.solve(flint.arb_mat(c.tolist()))
        closed = a - times * np.array((flint.arb_mat(b.tolist()) * back).tolist(), dtype=object)
        with mpmath.workdps(DIGITS):
            found = roots_of([_number(value) for value in _characteristic(closed)])
            return float(max((abs(root) - 1 for root in found), default=mpmath.mpf(-1)))

    def _turned(self, angle: float) -> Any:
        """Return the same for a turn at the wire: the characteristic polynomial times its conjugate is real."""
        a, b, c, d = self.whole
        turn = flint.acb(flint.arb(angle).cos(), -flint.arb(angle).sin())
        n = len(a)
        gain = flint.acb_mat((np.eye(self.values, dtype=int) + d * turn).tolist())
        back = gain.solve(flint.acb_mat(c.tolist()))
        closed = flint.acb_mat(a.tolist()) - flint.acb_mat((b * turn).tolist()) * back
        polynomial = closed.charpoly()
        with mpmath.workdps(DIGITS):
            real = [_number(polynomial[i].real) for i in range(n, -1, -1)]
            other = [_number(polynomial[i].imag) for i in range(n, -1, -1)]
            square = _convolved(real, real, 1) + _convolved(other, other, 1)
            found = roots_of(list(square))
            return max((abs(root) - 1 for root in found), default=mpmath.mpf(-1))

    def _stable_gains(self) -> list[tuple[float, float]]:
        places = np.linspace(-_LAST, _LAST, round(2 * _LAST * _PLACES) + 1)
        sizes = self._sizes(10.0**places)
        intervals, begin = [], 0.0 if sizes[0] < 0.0 else None
        for (low, high), (before, after) in zip(pairwise(places), pairwise(sizes), strict=True):
            if (before < 0.0) != (after < 0.0):
                edge = _zero(lambda x: self._outside(10.0**x), low, high)
                if edge is None:  # rounding
                    continue
                edge = 10.0**edge
                if begin is not None:
                    intervals.append((begin, edge))
                begin = edge if after < 0.0 else None
        return [*intervals, *([] if begin is None else [(begin, math.inf)])]

    def _turn(self) -> float | None:
        places = np.linspace(0.0, math.pi, 2 * _PLACES + 1)
        sizes = self._sizes(np.exp(-1j * places))
        for (low, high), after in zip(pairwise(places), sizes[1:], strict=True):
            if after >= 0.0 and high < math.pi and (turn := _zero(self._turned, low, high)) is not None:
                return turn
        return _zero(self._turned, places[-2], places[-1]) if sizes[-1] > _FAR else None

    def _delay_margin(self) -> float:
        """Return the time of whole values of the wire before the first with which the loop is unstable."""
        a, b, c, d = self.near
        n, m = len(a), self.values
        for late in range(1, MOST_DELAYED + 1):
            rows = np.eye(n + late)
            line = list(rows[n:])  # the values that are under way, the oldest first
            given = []
            for k in range(m):
                given.append(-line.pop(0))
                read = c[k] @ rows[:n] + sum((d[k, j] * given[j] for j in range(k)), np.zeros(n + late))
                line.append(read)
            moved = np.vstack([a @ rows[:n] + b @ np.array(given), *line])
            if np.max(np.abs(np.linalg.eigvals(moved))) >= 1.0 + _FAR:
                return (late - 1) * self.period / m
        return math.inf

    def _peak(self, offset: float) -> float:
        """Return the largest singular value of offset - T on the unit circle."""
        _, b, c, d = self.near
        inverse = np.linalg.inv(np.eye(self.values) + d)
        a, b, c, d = self._closed(np.ones(1))[0], b @ inverse, inverse @ c, offset * np.eye(self.values) - inverse @ d
        poles = np.linalg.eigvals(a)
        spread = np.concatenate([[0.0], np.geomspace(1e-2, 1e3, 60)])
        near = [
            np.angle(pole) + sign * max(1.0 - abs(pole), 1e-9) * spread
            for pole in poles
            for sign in (-1.0, 1.0)
            if abs(pole) > 1e-3
        ]
        angles = np.unique(np.concatenate([np.linspace(0.0, math.pi, 721), *near]))
        angles = angles[(angles >= 0.0) & (angles <= math.pi)]

        def size(angle: float) -> float:
            response = d - c @ np.linalg.solve(np.exp(1j * angle) * np.eye(len(a)) - a, b)
            return float(np.linalg.norm(response, 2))

        sizes = np.array([size(angle) for angle in angles])
        best = float(sizes.max())
        for i in np.flatnonzero(sizes >= 0.99 * best).tolist():
            low, high = angles[max(i - 1, 0)], angles[min(i + 1, len(angles) - 1)]
            found = _optimize.minimize_scalar(
                lambda x: -size(x), bounds=(low, high), method="bounded", options={"xatol": 1e-10 * max(high, 1e-6)}
            )
            best = max(best, -float(found.fun))
        return best


def _zero(curve: Callable[[float], float], low: float, high: float) -> float | None:
    """Return where a curve changes its sign, to rounding; None if it does not."""
    if (curve(low) < 0.0) == (curve(high) < 0.0):
        return None
    return float(_optimize.brentq(lambda x: float(curve(x)), low, high, xtol=1e-15, rtol=1e-14))


def _convolved(first: Sequence[Any], second: Sequence[Any], sign: int) -> Array:
    out = [mpmath.mpf(0)] * (len(first) + len(second) - 1)
    for i, one in enumerate(first):
        for j, other in enumerate(second):
            out[i + j] += sign * one * other
    return np.array(out, dtype=object)


def _sum(weights: Sequence[Any], rows: Array) -> Array:
    total = np.array([flint.arb(0)] * rows.shape[1], dtype=object)
    for weight, row in zip(weights, rows, strict=True):
        if weight != 0:
            total = total + (row if weight == 1 else weight * row)
    return total


def _one_number(matrix: Array) -> tuple[Array, int] | None:
    """Return a row, of which all rows of a matrix are multiples in all digits, and the place of its largest number."""
    near = np.abs(_doubles(matrix))
    i, j = (int(place) for place in np.unravel_index(int(np.argmax(near)), near.shape))
    if near[i, j] == 0.0:
        return None
    row = matrix[i]
    less = matrix - np.outer(matrix[:, j] / row[j], row)
    return (row, j) if all(abs(float(value.mid())) <= 1e-60 for value in less.ravel()) else None


def _characteristic(a: Array) -> list[Any]:
    """Return the characteristic polynomial, the highest power first."""
    if not len(a):
        return [flint.arb(1)]
    polynomial = flint.arb_mat(a.tolist()).charpoly()
    return [polynomial[i] for i in range(len(a), -1, -1)]


def _number(ball: Any) -> Any:
    """Return the middle of a ball; zero where it may be zero."""
    if ball.contains(0):
        return mpmath.mpf(0)
    mantissa, exponent = ball.mid().man_exp()
    return mpmath.ldexp(int(mantissa), int(exponent))


def _doubles(matrix: Array) -> Array:
    flat = [float(value.mid()) for value in matrix.ravel()]
    return np.array(flat).reshape(matrix.shape)
