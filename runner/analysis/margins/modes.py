"""Modes that a loop sees, and its stability by their closed-loop poles.

Two stages remove from the quotient N / D what the loop does not see:

1. factors that N and D share to the last bit: modes that the wire does not reach, or that do not reach it, such as the
   integrators of a CIC filter before its combs;
2. closed-loop poles on the boundary of stability, as far as that is known (`poles`), at which the open loop has a
   pole and a zero: no gain moves them, such as the neutral phase of an oscillation.

A pole and a zero that are close, but further apart than rounding, both count. N and D lose as many
zeros each: of a pair of conjugates of which one stays, the real part does.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import flint
import numpy as np

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.lasting import holders
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.poles import Pole, Verdict, judge, together
from proofmass.runner.analysis.linearisation.rational import Transfer, coprime, roots
from proofmass.runner.analysis.linearisation.real_roots import Polynomial
from proofmass.runner.host.arrays import Array


@dataclass(frozen=True)
class Mode:
    """A mode that the loop does not see, and the blocks that hold it, the most moved first."""

    pole: Pole
    times: int  # how often the loop has it
    blocks: tuple[str, ...]
    sampled: bool

    def __str__(self) -> str:
        """Return the mode in words: "an integrator that the loop does not see: ramp, delayed"."""
        value, verdict = self.pole.value, self.pole.verdict
        at_rest = abs(value - 1.0) if self.sampled else abs(value)
        if verdict == "marginal" and at_rest <= max(self.pole.uncertainty, 1e-9):
            kind = "integrator" if self.pole.distance == 0.0 else "neutral mode, such as the phase of an oscillation,"
        else:
            kind = "undamped oscillation" if verdict == "marginal" else "growing mode"
        article = "an" if kind[0] in "aeiou" else "a"
        often = "" if self.times == 1 else f", {self.times} times"
        return f"{article} {kind} that the loop does not see{often}: {', '.join(self.blocks)}"


def seen(system: OpenLoop, quotient: Transfer) -> tuple[Transfer, Verdict, tuple[Pole, ...], tuple[Mode, ...]]:
    """Return the visible part of a loop, its verdict, its closed-loop poles, the slowest first, and hidden modes."""
    sampled = not system.continuous
    numerator, denominator, common = coprime(quotient.numerator, quotient.denominator)
    unseen = [root for root in roots(common, sampled) if not (sampled and root.is_zero())]
    every = [*unseen, *roots(numerator + denominator, sampled)]
    known = judge(every, np.real(system.closed()), sampled, system.variation, system.ticks)
    hidden, visible = known[: len(unseen)], known[len(unseen) :]
    numerator, denominator, neutral = _without_shared(numerator, denominator, visible, sampled)
    verdict, poles = together(pole for pole in visible if not any(pole is other for other in neutral))
    return Transfer(numerator, denominator), verdict, poles, tuple(_modes([*hidden, *neutral], system))


def _without_shared(
    numerator: Polynomial, denominator: Polynomial, closed: Sequence[Pole], sampled: bool
) -> tuple[Polynomial, Polynomial, list[Pole]]:
    """Return both without the zeros next to poles on the boundary at which both have one, and these poles."""
    marginal = [pole for pole in closed if pole.verdict == "marginal"]
    if not marginal:
        return numerator, denominator, []
    ends = roots(numerator, sampled), roots(denominator, sampled)
    removed: tuple[list[Any], list[Any]] = ([], [])
    neutral = []
    for pole in marginal:
        near = [[root for root in end if abs(complex(root) - pole.value) <= 2.0 * pole.uncertainty] for end in ends]
        if all(near):
            neutral.append(pole)
            for end, gone, found in zip(ends, removed, near, strict=True):
                nearest = min(found, key=lambda root: abs(complex(root) - pole.value))
                end.remove(nearest)
                gone.append(nearest)
    if not neutral:
        return numerator, denominator, []
    first, second = (_without(part, gone) for part, gone in zip((numerator, denominator), removed, strict=True))
    below = math.lcm(int(first.denom()), int(second.denom()))
    return (first * below).numer(), (second * below).numer(), neutral


def _modes(hidden: Sequence[Pole], system: OpenLoop) -> Iterable[Mode]:
    """Hidden modes that do not decay, each once, a pair as one."""
    lasting = sorted((p for p in hidden if p.verdict != "stable" and p.value.imag >= 0.0), key=lambda p: p.distance)
    for pole in dict.fromkeys(lasting):
        times = lasting.count(pole)
        yield Mode(pole, times, _blocks_of(pole, system, times), not system.continuous)


def _without(polynomial: Polynomial, zeros: Sequence[Any]) -> Any:
    """Return a polynomial without some of its zeros; of a pair with one left, the real part."""
    left, divided = list(zeros), flint.fmpq_poly(polynomial)
    while left:
        zero = left.pop()
        real = -_fraction(zero.real)
        if zero.imag.is_zero():
            divided = divmod(divided, flint.fmpq_poly([real, 1]))[0]
            continue
        divided = divmod(divided, flint.fmpq_poly([real**2 + _fraction(zero.imag) ** 2, 2 * real, 1]))[0]
        other = next((root for root in left if root.overlaps(zero.conjugate())), None)
        if other is None:
            divided *= flint.fmpq_poly([real, 1])
        else:
            left.remove(other)
    return divided


def _fraction(ball: Any) -> Any:
    mantissa, exponent = ball.mid().man_exp()
    return flint.fmpq(mantissa * 2**exponent, 1) if exponent >= 0 else flint.fmpq(mantissa, 2 ** int(-exponent))


def _blocks_of(pole: Pole, system: OpenLoop, multiplicity: int) -> tuple[str, ...]:
    """Blocks that move in a hidden mode, those that move most first.

    Such a mode moves without being seen, or is not reached: vectors x with (A - p)^m x = 0 and C
    (A - p)^k x = 0, or the same of the transposed system (Popov, Belevitch and Hautus; Kailath,
    Linear Systems, 6.2).
    """
    a, b, c, _ = system.matrices
    alike, scale = balanced(a)
    parts = _unseen(alike, c * scale, pole, multiplicity)
    if not parts.any():
        parts = _unseen(alike.T, (b / scale[:, None]).T, pole, multiplicity)
    return holders(parts, [entry[0] for entry in system.map.states]) if parts.any() else ()


def _unseen(a: Array, c: Array, pole: Pole, multiplicity: int) -> Array:
    """Return the part of each state in the modes at a pole that c does not show."""
    less = a - pole.value * np.eye(len(a))
    powers = [np.eye(len(a), dtype=complex)]
    for _ in range(multiplicity):
        powers.append(less @ powers[-1])
    rows = np.vstack([powers[-1], *(c @ power for power in powers[:-1])])
    _, sizes, turned = np.linalg.svd(rows)
    missing = sizes <= max(1e-9, 10.0 * pole.uncertainty) * max(sizes[0], 1.0)
    return np.asarray(np.sqrt((np.abs(turned[missing]) ** 2).sum(axis=0)))
