"""Random loops and their margins from the graph's own numbers, by polynomials in mpmath; nothing of the product counts.

L = N / D is multiplied from the coefficients of the blocks. With the mirrored polynomials p*(s) = p(-s), or
z^n p(1/z) of a sampled loop, everything is a root on the axis: |L| = 1 where N N* = D D*, L real where N D* = N* D,
and |A / B| has a peak where the derivative of A A* / (B B*) is zero.
"""

import itertools
import math
import random
from collections.abc import Sequence
from typing import Any, NamedTuple

import flint
import mpmath

from proofmass.blocks import (
    Constant,
    Delay,
    Difference,
    DiscreteTransferFunction,
    FractionalDelay,
    Gain,
    LowPass,
    MovingAverage,
    TransferFunction,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.graphs.model.build import Graph

DIGITS = 80
_BITS = 512
_ON_THE_AXIS = mpmath.mpf(10) ** -30
_TURN = 2.0 * math.pi
Polynomial = list[Any]  # coefficients, the highest power first


class Part(NamedTuple):
    """A block of a chain, the output that is read, and its transfer function."""

    block: Block
    output: str
    numerator: Polynomial
    denominator: Polynomial


class Truth(NamedTuple):
    """What a loop has; frequencies are in Hz."""

    outside: float  # of the slowest closed-loop pole, relative to the fastest of a continuous loop
    gain_margin: float | None
    gain_reduction: float | None
    phase_margin: float | None
    delay_margin: float | None
    disk_margin: float
    sensitivity_peak: float
    stable_gains: list[tuple[float, float]]


def analog_loop(number: int) -> tuple[Graph, Truth]:
    """Return a chain of integrators, low-pass filters and resonators with negative feedback, and what it has."""
    dice = random.Random(number)
    parts = []
    for _ in range(dice.randint(1, 4)):
        w = 10.0 ** dice.uniform(-1.0, 3.0)
        match dice.randint(0, 3):
            case 0:
                parts.append(_filter(TransferFunction, [w], [1.0, 0.0]))
            case 1:
                corner = w / _TURN
                lag = mpmath.mpf(corner) * 2 * mpmath.pi
                parts.append(Part(LowPass(corner_frequency=corner), "output", [lag], [1, lag]))
            case 2:
                parts.append(_filter(TransferFunction, [w], [1.0, w]))
            case _:
                quality = 10.0 ** dice.uniform(-0.3, 3.0)
                zero = dice.choice([[], [w * dice.uniform(-0.5, 2.0)]])
                parts.append(_filter(TransferFunction, [*zero, w * w], [1.0, w / quality, w * w]))
    gain = dice.choice([1.0, 1.0, -1.0]) * 10.0 ** dice.uniform(-1.5, 2.0)
    return _graph(number, "1 kHz", gain, parts), _truth(gain, parts, None)


def sampled_loop(number: int) -> tuple[Graph, Truth]:
    """Return a chain of integrators, poles, resonators and delays at one rate with negative feedback."""
    dice = random.Random(number)
    rate = 10.0 ** dice.uniform(0.0, 5.0)
    parts = [Part(UnitDelay(), "output", [1], [1, 0])]
    for _ in range(dice.randint(1, 4)):
        w = 10.0 ** dice.uniform(-3.0, 0.3)  # rad in a tick
        match dice.randint(0, 3):
            case 0:
                parts.append(_filter(DiscreteTransferFunction, [w], [1.0, -1.0]))
            case 1:
                parts.append(Part(UnitDelay(), "output", [1], [1, 0]))
            case 2:
                pole = math.exp(-w)
                parts.append(_filter(DiscreteTransferFunction, [1.0 - pole], [1.0, -pole]))
            case _:
                size = math.exp(-w * 10.0 ** dice.uniform(-3.0, 0.0))
                denominator = [1.0, -2.0 * size * math.cos(w), size * size]
                zero = dice.choice([[], [w * w * dice.uniform(-0.5, 0.5)]])
                parts.append(_filter(DiscreteTransferFunction, [*zero, w * w], denominator))
    gain = dice.choice([1.0, 1.0, -1.0]) * 10.0 ** dice.uniform(-2.0, 0.5)
    return _graph(number, rate, gain, parts), _truth(gain, parts, rate)


def ringed_loop(number: int) -> tuple[Graph, Truth]:
    """Return a chain of delay lines, means, delays of fractions and slow poles at one rate, and what it has."""
    dice = random.Random(number)
    rate = 10.0 ** dice.uniform(0.0, 5.0)
    parts = [_ring(dice)]
    for _ in range(dice.randint(1, 2)):
        parts.append(_ring(dice) if dice.random() < 0.5 else _slow(dice))
    parts.append(_slow(dice))
    gain = dice.choice([1.0, 1.0, -1.0]) * 10.0 ** dice.uniform(-2.0, 0.5)
    return _graph(number, rate, gain, parts), _truth(gain, parts, rate)


def _ring(dice: random.Random) -> Part:
    """Return a block whose memory is a ring."""
    length = dice.choice([1, 2, 2, 3, 5, 8])
    match dice.randint(0, 3):
        case 0:
            return Part(Delay(ticks=length), "output", [1], [1, *([0] * length)])
        case 1:
            return Part(Line(ticks=length), "output", [1], [1, *([0] * length)])
        case 2:
            share = mpmath.mpf(1) / length
            return Part(MovingAverage(length=length), "mean", [share] * length, [1, *([0] * (length - 1))])
        case _:
            delay = length + dice.choice([0.25, 0.5, 0.75])
            nodes = [max(length - 1, 0) + i for i in range(4)]
            weights = [_lagrange(mpmath.mpf(delay), nodes, i) for i in range(4)]
            block = FractionalDelay(delay=delay, longest=dice.choice([12, 16]))
            return Part(block, "output", weights, [1, *([0] * nodes[-1])])


def _lagrange(at: Any, nodes: Sequence[int], own: int) -> Any:
    """Return the value at a place of the polynomial that is 1 at a node and 0 at the others."""
    value = mpmath.mpf(1)
    for other in nodes:
        if other != nodes[own]:
            value *= (at - other) / (nodes[own] - other)
    return value


def _slow(dice: random.Random) -> Part:
    """Return an integrator, or a pole near 1, as close as 1e-9."""
    pole = dice.choice([1.0, 1.0 - 10.0 ** dice.uniform(-9.0, -0.5)])
    return _filter(DiscreteTransferFunction, [10.0 ** dice.uniform(-3.0, -0.5)], [1.0, -pole])


class Line(Block):
    """Delay line of an own block, that writes one cell of a ring and reads another."""

    ticks: int = param("1", "Ticks.", default=3, at_least=1, at_most=15)

    input = Input("1", "Signal to delay.")

    line = Buffer("The last inputs.", float, (16,))


class Place(NamedTuple):
    """Where the next input goes."""

    place: int


@Line.output("1")
def output(p: Line, x: Place, line: list[float]) -> float:
    """The input of some ticks before."""
    return line[(x.place - p.ticks) % 16]


@Line.update
def update(p: Line, x: Place, line: list[float], input: float) -> Place:
    line[x.place] = input
    return Place((x.place + 1) % 16)


def _filter(kind: type[Block], numerator: list[float], denominator: list[float]) -> Part:
    return Part(kind(numerator=numerator, denominator=denominator), "strictly_proper_part", numerator, denominator)


def _graph(number: int, rate: str | float, gain: float, parts: Sequence[Part]) -> Graph:
    blocks: dict[str, Block] = {"zero": Constant(value=0.0), "error": Difference(), "gain": Gain(gain=gain)}
    wires = ["zero.output -> error.first", "error.output -> gain.input"]
    last = "gain.output"
    for i, part in enumerate(parts):
        blocks[f"part_{i}"] = part.block
        wires.append(f"{last} -> part_{i}.input")
        last = f"part_{i}.{part.output}"
    wires.append(f"{last} -> error.second")
    rates = {name: rate for name, block in blocks.items() if not type(block).continuous() and isinstance(rate, float)}
    return Graph(
        name=f"loop {number}", rate=rate, rates=rates, blocks=blocks, wires=wires, loops={"main": {"open_at": last}}
    )


def _truth(gain: float, parts: Sequence[Part], rate: float | None) -> Truth:
    with mpmath.workdps(DIGITS):
        numerator: Polynomial = [mpmath.mpf(gain)]
        denominator: Polynomial = [mpmath.mpf(1)]
        for part in parts:
            numerator = _product(numerator, [mpmath.mpf(value) for value in part.numerator])
            denominator = _product(denominator, [mpmath.mpf(value) for value in part.denominator])
        numerator = [mpmath.mpf(0)] * (len(denominator) - len(numerator)) + numerator
        return truth_of_quotient(numerator, denominator, rate)


def truth_of_quotient(numerator: Polynomial, denominator: Polynomial, rate: float | None) -> Truth:
    """Return what a loop L = N / D has, with as many coefficients in both; at a rate, or in continuous time."""
    return _Loop(numerator, denominator, rate).truth()


class _Loop:
    """N and D of the same formal degree."""

    def __init__(self, numerator: Polynomial, denominator: Polynomial, rate: float | None) -> None:
        self.numerator, self.denominator, self.rate = numerator, denominator, rate

    def truth(self) -> Truth:
        """Return everything."""
        top, bottom = self.numerator, self.denominator
        closed = _sum(top, bottom)
        gains = self._on_the_axis(_less(self._square(top), self._square(bottom)))
        crossed = _less(_product(top, self._mirrored(bottom)), _product(self._mirrored(top), bottom))
        sizes = [-self._at(place) for place in [*self._on_the_axis(crossed), *self._ends()] if self._at(place) != 0]
        factors = sorted({float(1 / size.real) for size in sizes if size.real > 0 and mpmath.isfinite(size)})
        factors = [factor for factor in factors if 1e-9 < factor < 1e9]
        stable = self._outside(closed) < 0.0
        lags = [(mpmath.arg(-self._at(place)), self._frequency(place)) for place in gains]
        return Truth(
            self._outside(closed),
            min((f for f in factors if f > 1.0), default=None) if stable else None,
            max((f for f in factors if f < 1.0), default=None) if stable else None,
            min((float(abs(lag)) for lag, _ in lags), default=None),
            min([*(float((lag % (2 * mpmath.pi)) / w) for lag, w in lags), *self._one_more_sample()], default=None),
            2.0 / self._peak(_less(bottom, top), closed),
            self._peak(bottom, closed),
            self._stable_gains(factors),
        )

    def _one_more_sample(self) -> list[float]:
        """Return the time of one more sample if the loop is unstable with it: z D + N."""
        if self.rate is None or self._outside(_sum([0, *self.numerator], [*self.denominator, 0])) < 0.0:
            return []
        return [1.0 / self.rate]

    def _stable_gains(self, factors: list[float]) -> list[tuple[float, float]]:
        intervals = []
        for low, high in itertools.pairwise([0.0, *factors, math.inf]):
            inner = 2.0 * low + 1.0 if math.isinf(high) else 0.5 * (low + high)
            closed = _sum([inner * value for value in self.numerator], self.denominator)
            if self._outside(closed) < 0.0:
                intervals.append((low, high))
        return intervals

    def _mirrored(self, p: Polynomial) -> Polynomial:
        if self.rate is not None:
            return p[::-1]
        return [value * (-1) ** (len(p) - 1 - i) for i, value in enumerate(p)]

    def _square(self, p: Polynomial) -> Polynomial:
        return _product(p, self._mirrored(p))

    def _on_the_axis(self, p: Polynomial) -> list[Any]:
        """Return the roots on the upper half of the axis, apart from its ends."""
        if self.rate is not None:
            on = [z for z in roots_of(p) if abs(abs(z) - 1) < _ON_THE_AXIS and z.imag > _ON_THE_AXIS]
        else:
            on = [s for s in roots_of(p) if s.imag > 0 and abs(s.real) < _ON_THE_AXIS * abs(s)]
        return on

    def _ends(self) -> list[Any]:
        return [mpmath.mpf(1), mpmath.mpf(-1)] if self.rate is not None else [mpmath.mpf(0)]

    def _at(self, place: Any) -> Any:
        bottom = _value(self.denominator, place)
        return _value(self.numerator, place) / bottom if bottom else mpmath.inf

    def _frequency(self, place: Any) -> Any:
        return mpmath.arg(place) * self.rate if self.rate is not None else place.imag

    def _peak(self, above: Polynomial, below: Polynomial) -> float:
        top, bottom = self._square(above), self._square(below)
        slope = _less(_product(_derivative(top), bottom), _product(top, _derivative(bottom)))
        places = [*self._on_the_axis(slope), *self._ends()]
        sizes = [abs(_value(above, s) / _value(below, s)) for s in places if _value(below, s)]
        if self.rate is None:  # L is 0 at infinite frequency
            sizes.append(mpmath.mpf(1))
        return float(max(sizes))

    def _outside(self, closed: Polynomial) -> float:
        roots = roots_of(closed)
        if self.rate is not None:
            return float(max((abs(z) - 1 for z in roots), default=mpmath.mpf(-1)))
        return float(max(s.real for s in roots) / max(abs(s) for s in roots)) if roots else -1.0


def roots_of(p: Polynomial) -> list[Any]:
    """Return the roots other than exact ones at 0, 1 and -1 of more than one, which are divided out once too often."""
    p = list(p)
    largest = max(map(abs, p), default=mpmath.mpf(0))
    least = largest * mpmath.mpf(10) ** (-DIGITS // 2)
    while p and abs(p[0]) <= least * mpmath.mpf(10) ** -20:
        p.pop(0)
    zeros = 0
    while len(p) > 1 and p[-1] == 0:
        p.pop()
        zeros += 1
    ends: list[Any] = [mpmath.mpf(0)] * min(zeros, 1)
    for end in (1, -1):
        while len(p) > 1 and abs(_value(p, end)) <= least * mpmath.mpf(10) ** -20:
            p = _divided(p, end)
            ends = [*ends, mpmath.mpf(end)]
    if len(p) < 2:
        return ends
    return [*ends, *_apart(p)]


def _apart(p: Polynomial) -> list[Any]:
    """Return the roots of a polynomial, those of its numbers as they are: isolated by Arb."""
    flint.ctx.prec = _BITS
    exact: Any = flint.fmpq_poly([flint.fmpq(*_quotient(value)) for value in reversed(p)])
    roots: Any = exact.numer().complex_roots()
    return [_number(root) for root, times in roots for _ in range(times)]


def _quotient(value: Any) -> tuple[int, int]:
    sign, mantissa, exponent, _ = mpmath.mpf(value)._mpf_
    whole = -int(mantissa) if sign else int(mantissa)
    return (whole << exponent, 1) if exponent >= 0 else (whole, 1 << -exponent)


def _number(root: Any) -> Any:
    parts = [part.mid().man_exp() for part in (root.real, root.imag)]
    number: Any = mpmath.mpc
    return number(*(mpmath.ldexp(int(mantissa), int(exponent)) for mantissa, exponent in parts))


def _value(p: Polynomial, place: Any) -> Any:
    value = mpmath.mpf(0)
    for coefficient in p:
        value = value * place + coefficient
    return value


def _divided(p: Polynomial, root: int) -> Polynomial:
    quotient, carried = [], mpmath.mpf(0)
    for value in p[:-1]:
        carried = carried * root + value
        quotient.append(carried)
    return quotient


def _product(first: Polynomial, second: Polynomial) -> Polynomial:
    out = [mpmath.mpf(0)] * (len(first) + len(second) - 1)
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            out[i + j] += a * b
    return out


def _sum(first: Polynomial, second: Polynomial) -> Polynomial:
    length = max(len(first), len(second))
    first, second = ([mpmath.mpf(0)] * (length - len(p)) + list(p) for p in (first, second))
    return [a + b for a, b in zip(first, second, strict=True)]


def _less(first: Polynomial, second: Polynomial) -> Polynomial:
    return _sum(first, [-value for value in second])


def _derivative(p: Polynomial) -> Polynomial:
    n = len(p) - 1
    return [value * (n - i) for i, value in enumerate(p[:-1])]
