"""Margins of random sampled loops by mpmath, in as many digits as it takes; nothing of the product computes them.

The characteristic polynomials come from Faddeev and LeVerrier's recursion, crossovers from Sturm's chains in
y = 2 - z - 1/z, verdicts from Schur and Cohn's test, where the product works with integers and t = tan(w T / 2).
`python -m tests.by_hand.margins_oracle 10000` compares as many random loops, and prints what differs (half an hour on a
quiet core).
"""

import itertools
import math
import random
import sys
from fractions import Fraction
from typing import Any, NamedTuple

import mpmath

from proofmass.blocks import Difference, DiscreteIntegrator, DiscreteTransferFunction, Gain, TransferFunction, UnitDelay
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.margins import Margins, margins_of
from proofmass.runner.planning.plan import plan

DIGITS = 600
_LARGEST = 1e9  # a gain margin beyond it is no limit


class Truth(NamedTuple):
    """What a loop has; angles are w T in radians."""

    outside: float  # largest size of a closed-loop pole that the loop sees, less 1
    gain_margin: float | None
    phase_margin: float | None
    gain_crossovers: list[float]
    phase_crossovers: list[float]


def random_loop(number: int) -> Graph:
    """A chain at up to three rates: resonators of any Q, poles, integrators, delays, hidden modes."""
    dice = random.Random(number)
    rate = 10.0 ** dice.uniform(0.0, 6.0)
    base = Fraction(rate)
    divisors = sorted(dice.choice([(1,), (1,), (1, 2), (1, 3), (1, 2, 4), (1, 2, 6)]))
    slow = base / divisors[-1]
    blocks: dict[str, Block] = {}
    rates: dict[str, Fraction] = {}
    wires: list[str] = []

    def append(name: str, block: Block, divisor: int, source: str, port: str = "input", output: str = "output") -> str:
        blocks[name], rates[name] = block, base / divisor
        wires.append(f"{source} -> {name}.{port}")
        return f"{name}.{output}"

    last = "out.strictly_proper_part"
    scale = 10.0 ** dice.uniform(-9.0, -1.0)  # of the dynamics, in the slowest rate
    order = dice.randint(1, 8)
    number_of_parts = 0
    while order > 0:
        w = 2.0 * math.pi * float(slow) * scale * 10.0 ** dice.uniform(-1.0, 0.6)
        w = min(w, 0.8 * math.pi * float(slow))
        name, divisor = f"part_{number_of_parts}", dice.choice(divisors)
        number_of_parts += 1
        kind = dice.random()
        if order >= 2 and kind < 0.5:
            damping = w / (2.0 * 10.0 ** dice.uniform(-0.3, 9.0))
            block: Block = TransferFunction(numerator=(w * w,), denominator=(1.0, 2.0 * damping, w * w))
            blocks[name] = block
            wires.append(f"{last} -> {name}.input")
            last = append(f"{name}_held", Gain(gain=1.0), divisors[0], f"{name}.strictly_proper_part")
            order -= 2
        elif kind < 0.8:
            pole = math.exp(-w / float(base) * divisor)
            last = append(
                name, DiscreteTransferFunction(numerator=(1.0 - pole,), denominator=(1.0, -pole)), divisor, last
            )
            order -= 1
        else:
            last = append(name, DiscreteIntegrator(output_unit="1", gain=w), divisor, last)
            order -= 1
    for i in range(dice.randint(0, 3)):
        last = append(f"delay_{i}", UnitDelay(), dice.choice(divisors), last)
    if dice.random() < 0.2:  # an integrator behind which a difference is taken: a mode that the loop does not see
        ramp = append("ramp", DiscreteIntegrator(output_unit="1", gain=float(slow)), divisors[-1], last)
        delayed = append("before", UnitDelay(), divisors[-1], ramp)
        wires.append(f"{delayed} -> change.second")
        last = append("change", Difference(), divisors[-1], ramp, "first")
    if dice.random() < 0.2:  # a zero next to a pole
        near, apart = 1.0 - 10.0 ** dice.uniform(-7.0, -1.0), 10.0 ** dice.uniform(-9.0, -3.0)
        pair = DiscreteTransferFunction(numerator=(1.0, -near * (1.0 - apart)), denominator=(1.0, -near))
        last = append("pair", pair, divisors[-1], last)
    if dice.random() < 0.3:  # lead: two zeros' worth of phase
        zero = math.exp(-2.0 * math.pi * min(scale * 10.0 ** dice.uniform(-1.0, 0.5), 0.3))
        lead = DiscreteTransferFunction(numerator=(1.0 / (1.0 - zero), -zero / (1.0 - zero)), denominator=(1.0, 0.0))
        last = append("lead", lead, divisors[-1], last)
    last = append("gain", Gain(gain=-1.0), divisors[-1], last)
    out = DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, 0.0))
    append("out", out, divisors[-1], last)
    return Graph(name="random loop", rate=base, blocks=blocks, rates=rates, wires=wires)


def random_system(number: int) -> OpenLoop:
    """The loop opened at its slowest wire, with a gain that gives it a crossover at a frequency drawn."""
    graph = random_loop(number)
    planned = plan(graph)
    system = linearised(planned).loop(("out", "strictly_proper_part"))
    dice = random.Random(-number - 1)
    angle = math.pi * 10.0 ** dice.uniform(-9.0, -0.05)
    with mpmath.workdps(DIGITS):
        size = abs(_quotient(*_polynomials(system), mpmath.expj(angle)))
        gain = float(min(max(1 / size, mpmath.mpf(10) ** -30), mpmath.mpf(10) ** 30)) if size else 1.0
    return linearised(plan(graph.with_parameters({"gain.gain": -gain}))).loop(("out", "strictly_proper_part"))


def truth_of(system: OpenLoop) -> Truth:
    """All that is compared, from the matrices of the loop at its slowest wire."""
    with mpmath.workdps(DIGITS):
        numerator, denominator = _polynomials(system)
        while _is_zero(sum(numerator), numerator) and _is_zero(sum(denominator), denominator):
            numerator, denominator = _without_one(numerator), _without_one(denominator)
        closed = _added(numerator, denominator)
        size = _correlated(numerator, numerator), _correlated(denominator, denominator)
        crossed = _angles(_in_y([a - b for a, b in zip(*_same_length(*size), strict=True)], even=True))
        gains = [angle for angle in crossed if not _flat(numerator, denominator, angle)]
        turned = _in_y(_turned(numerator, denominator), even=False)
        values = {angle: _quotient(numerator, denominator, mpmath.expj(angle)) for angle in _angles(turned)}
        ends = {0.0: sum(numerator), math.pi: sum(c * (-1) ** i for i, c in enumerate(numerator))}
        below = {0.0: sum(denominator), math.pi: sum(c * (-1) ** i for i, c in enumerate(denominator))}
        values |= {angle: top / below[angle] for angle, top in ends.items() if not _is_zero(below[angle], denominator)}
        negative = {angle: -value.real for angle, value in values.items() if value.real < 0}
        factors = [1 / value for value in negative.values() if 1 / _LARGEST < value < _LARGEST]
        lags = [abs(mpmath.arg(-_quotient(numerator, denominator, mpmath.expj(angle)))) for angle in gains]
        return Truth(
            _outside(closed),
            min((float(f) for f in factors if f > 1), default=None),
            min(map(float, lags), default=None),
            sorted(map(float, gains)),
            sorted(float(angle) for angle in negative if angle > 0.0),
        )


def differences(system: OpenLoop, found: Margins, truth: Truth) -> list[str]:
    """What of the margins is not as it is: 1e-6 of gains, 1e-6 degrees, every crossover, the verdict."""
    told: list[str] = []
    edge = 1e-12
    allowed = {"stable"} if truth.outside < -edge else {"unstable"} if truth.outside > edge else {"marginal"}
    if abs(truth.outside) <= edge:
        allowed.add("stable" if truth.outside < 0.0 else "unstable")
    if found.verdict not in allowed:
        told.append(f"{found.verdict}, but the slowest pole is {truth.outside:.3g} outside")
    period = 2.0 * math.pi * system.map.period
    for name, got, expected in (
        ("gain", [f * period for f in found.gain_crossovers], truth.gain_crossovers),
        ("phase", [f * period for f in found.phase_crossovers], truth.phase_crossovers),
    ):
        near = len(got) == len(expected) and all(
            abs(a - b) <= 1e-9 * b for a, b in zip(sorted(got), expected, strict=True)
        )
        if not near:
            told.append(f"{name} crossovers {got} for {expected}")
    if found.verdict == "stable":
        if (found.gain_margin is None) != (truth.gain_margin is None) or (
            found.gain_margin is not None and abs(found.gain_margin / (truth.gain_margin or 1.0) - 1.0) > 1e-6
        ):
            told.append(f"gain margin {found.gain_margin} for {truth.gain_margin}")
        if (found.phase_margin is None) != (truth.phase_margin is None) or (
            found.phase_margin is not None
            and math.degrees(abs(found.phase_margin - (truth.phase_margin or 0.0))) > 1e-6
        ):
            told.append(f"phase margin {found.phase_margin} for {truth.phase_margin}")
    return told


def _polynomials(system: OpenLoop) -> tuple[list[Any], list[Any]]:
    """N and D, the lowest power first: adj(z - A) by Faddeev and LeVerrier."""
    with mpmath.workdps(DIGITS):
        a, b, c, d = (mpmath.matrix(part.tolist()) for part in system.matrices)
        n = a.rows
        matrix, numerator, denominator = mpmath.eye(n), [], [mpmath.mpf(1)]
        for k in range(1, n + 1):
            numerator.append((c * matrix * b)[0])
            product = a * matrix
            coefficient = -sum(product[i, i] for i in range(n)) / k
            denominator.append(coefficient)
            matrix = product + coefficient * mpmath.eye(n)
        numerator = [mpmath.mpf(0), *numerator]
        numerator = [top + d[0] * bottom for top, bottom in zip(numerator, denominator, strict=True)]
        return numerator[::-1], denominator[::-1]


def _quotient(numerator: list[Any], denominator: list[Any], z: Any) -> Any:
    bottom = _at(denominator, z)
    return _at(numerator, z) / bottom if bottom else mpmath.inf


def _flat(numerator: list[Any], denominator: list[Any], angle: Any) -> bool:
    """Whether |L| is 1 from rest to there but for rounding, as where low-pass filters pass what is slow unchanged."""
    sizes = [abs(_quotient(numerator, denominator, mpmath.expj(angle * part))) for part in (0, 0.1, 0.5, 0.9)]
    return all(abs(size - 1) < 1e-12 for size in sizes)


def _at(polynomial: list[Any], z: Any) -> Any:
    value = mpmath.mpf(0)
    for coefficient in reversed(polynomial):
        value = value * z + coefficient
    return value


def _is_zero(value: Any, of: list[Any]) -> bool:
    return bool(abs(value) <= mpmath.mpf(10) ** (-DIGITS // 2) * max(map(abs, of)))


def _without_one(polynomial: list[Any]) -> list[Any]:
    """Divided by z - 1."""
    quotient, carried = [], mpmath.mpf(0)
    for coefficient in polynomial[:0:-1]:
        carried += coefficient
        quotient.append(carried)
    return quotient[::-1]


def _added(first: list[Any], second: list[Any]) -> list[Any]:
    return [a + b for a, b in zip(*_same_length(first, second), strict=True)]


def _same_length(first: list[Any], second: list[Any]) -> tuple[list[Any], list[Any]]:
    length = max(len(first), len(second))
    return tuple(part + [mpmath.mpf(0)] * (length - len(part)) for part in (first, second))  # type: ignore[return-value]


def _correlated(first: list[Any], second: list[Any]) -> list[Any]:
    """c_k of first(z) second(1/z) = sum of c_k z^k over k >= 0, and of the mirrored part below."""
    return [sum(first[i + k] * second[i] for i in range(min(len(second), len(first) - k))) for k in range(len(first))]


def _turned(numerator: list[Any], denominator: list[Any]) -> list[Any]:
    """s_k of N(z) D(1/z) - N(1/z) D(z) = sum of s_k (z^k - z^-k), k >= 1 (s_0 = 0)."""
    return [
        a - b for a, b in zip(_correlated(numerator, denominator), _correlated(denominator, numerator), strict=True)
    ]


def _in_y(terms: list[Any], even: bool) -> list[Any]:
    """A sum of 2 T_k or of U_(k-1), at cosine 1 - y/2, as a polynomial in y = 2 - z - 1/z, the lowest power first."""
    x = [mpmath.mpf(2), mpmath.mpf(-1)]  # z + 1/z
    before, now = ([mpmath.mpf(2)], x) if even else ([mpmath.mpf(0)], [mpmath.mpf(1)])
    total = [terms[0]] if even else [mpmath.mpf(0)]
    for term in terms[1:]:
        total = _added(total, [term * value for value in now])
        product = [mpmath.mpf(0)] * (len(now) + 1)
        for i, value in enumerate(now):
            product[i] += 2 * value
            product[i + 1] -= value
        before, now = now, _added(product, [-value for value in before])
    return total


def _angles(polynomial: list[Any]) -> list[Any]:
    """Angles at which a polynomial in y = 2 - 2 cos(angle) is zero, apart from the ends, by Sturm's chain."""
    chain = _chain(polynomial)
    low, high = mpmath.mpf(10) ** -30, 4 - mpmath.mpf(10) ** -30
    roots: list[Any] = []
    open_intervals = [(low, high, _changes(chain, low), _changes(chain, high))]
    while open_intervals:
        left, right, at_left, at_right = open_intervals.pop()
        if at_left == at_right:
            continue
        if at_left - at_right == 1 and chain[0] and _sign(chain[0], left) * _sign(chain[0], right) < 0:
            roots.append(_zero(chain[0], left, right))
            continue
        if right / left < 1 + mpmath.mpf(10) ** -60:
            roots.append(left)
            continue
        middle = mpmath.sqrt(left * right)
        between = _changes(chain, middle)
        open_intervals += [(left, middle, at_left, between), (middle, right, between, at_right)]
    return sorted(2 * mpmath.asin(mpmath.sqrt(root) / 2) for root in roots)


def _zero(polynomial: list[Any], left: Any, right: Any) -> Any:
    """The zero in an interval with a change of sign, by halving it in the logarithm."""
    at_left = _sign(polynomial, left)
    while right / left > 1 + mpmath.mpf(10) ** -40:
        middle = mpmath.sqrt(left * right)
        left, right = (middle, right) if _sign(polynomial, middle) == at_left else (left, middle)
    return left


def _chain(polynomial: list[Any]) -> list[list[Any]]:
    """Sturm's chain, each scaled to a largest coefficient of 1; it ends where a remainder is nothing but rounding."""
    first = _trimmed(polynomial)
    if not first:
        return [[]]
    chain = [first, _trimmed([i * value for i, value in enumerate(first)][1:])]
    while chain[-1]:
        remainder = [-value for value in _remainder(chain[-2], chain[-1])]
        chain.append(_trimmed(remainder, mpmath.mpf(10) ** (-DIGITS // 2)))
    return chain[:-1]


def _trimmed(polynomial: list[Any], least: Any = 0) -> list[Any]:
    largest = max(map(abs, polynomial), default=mpmath.mpf(0))
    if largest <= least or largest == 0:
        return []
    kept = list(polynomial)
    while kept and abs(kept[-1]) <= mpmath.mpf(10) ** (-DIGITS + 40) * largest:
        kept.pop()
    return [value / largest for value in kept]


def _remainder(above: list[Any], below: list[Any]) -> list[Any]:
    rest = list(above)
    while len(rest) >= len(below):
        factor = rest[-1] / below[-1]
        for i, value in enumerate(below):
            rest[len(rest) - len(below) + i] -= factor * value
        rest.pop()
    return rest


def _sign(polynomial: list[Any], y: Any) -> int:
    return int(mpmath.sign(_at(polynomial, y)))


def _changes(chain: list[list[Any]], y: Any) -> int:
    signs = [sign for part in chain if part and (sign := _sign(part, y))]
    return sum(a != b for a, b in itertools.pairwise(signs))


def _outside(closed: list[Any]) -> float:
    """How far the largest zero lies outside the unit circle, within a factor of 2 about it: Schur and Cohn's test."""
    for sign in (-1, 1):
        for exponent in range(-2, -17, -1):
            radius = 1 + sign * mpmath.mpf(10) ** exponent
            inside = _all_inside([value * radius**i for i, value in enumerate(closed)])
            if sign < 0 and inside:
                return -(10.0**exponent)
            if sign > 0 and not inside:
                return 10.0**exponent
    return 0.0


def _all_inside(polynomial: list[Any]) -> bool:
    """Whether all zeros lie inside the unit circle."""
    rest = list(polynomial)
    while rest and rest[-1] == 0:
        rest.pop()
    while len(rest) > 1:
        if abs(rest[0]) >= abs(rest[-1]):
            return False
        factor = rest[0] / rest[-1]
        rest = [value - factor * mirrored for value, mirrored in zip(rest, rest[::-1], strict=True)][1:]
    return True


def main(first: int, last: int) -> int:
    """Compare the loops of these numbers, print what differs and how many were what."""
    told: dict[str, int] = {}
    wrong = 0
    for number in range(first, last):
        system = random_system(number)
        found, truth = margins_of(system, "main", "out.strictly_proper_part"), truth_of(system)
        told[found.verdict] = told.get(found.verdict, 0) + 1
        for line in differences(system, found, truth):
            wrong += 1
            print(f"loop {number}, order {system.map.order}: {line}", flush=True)
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in sorted(told.items()))
    print(f"{last - first} loops: {verdicts}; {wrong} differences")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(*([0, int(sys.argv[1])] if len(sys.argv) == 2 else map(int, sys.argv[1:3]))))
