"""Random loops that repeat after a period, and their margins from the graph's numbers; nothing of the product counts.

Each part is a list of small matrices, one for each tick of its period. `lifted_loops` multiplies a period of the loop
from them, and finds its margins.
"""

import itertools
import math
import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import flint
import mpmath

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
from tests.by_hand.lifted_loops import BITS, Lifted, Part, Tick
from tests.by_hand.polynomial_loops import DIGITS, Line, Truth

_ON_THE_BOUNDARY = 1e-11
_ANOTHER = 10_000_000


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
        graph, lifted = drawn(number + again * longest)
        truth = lifted.truth()
        if abs(truth.outside) > _ON_THE_BOUNDARY:
            return graph, truth
    raise AssertionError


def drawn(number: int, longest: int = 12) -> tuple[Graph, Lifted]:
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
