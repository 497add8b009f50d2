"""Modes that a loop sees, and its stability by their closed-loop poles.

Two stages remove from the quotient N / D what the loop does not see:

1. factors that N and D share to the last bit: modes that the wire does not reach, or that do not reach it, such as the
   integrators of a CIC filter before its combs;
2. closed-loop poles on the boundary of stability, as far as that is known (`poles`), at which the open loop has a
   pole and a zero: no gain moves them, such as the neutral phase of an oscillation.

A pole and a zero that are close, but further apart than rounding, both count.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import flint
import numpy as np

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.period_map import Array, Entry
from proofmass.runner.analysis.linearisation.poles import Pole, Verdict, judge, together
from proofmass.runner.analysis.linearisation.rational import Polynomial, Transfer, coprime, roots


@dataclass(frozen=True)
class Mode:
    """A mode that the loop does not see, and the blocks that hold it, those that move most first."""

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


@dataclass(frozen=True)
class Seen:
    """The visible part of a loop: its quotient and closed-loop poles, slowest first; and the hidden modes."""

    transfer: Transfer
    verdict: Verdict
    poles: tuple[Pole, ...]
    hidden: tuple[Mode, ...]


def seen(
    whole: Transfer,
    opened: tuple[Array, Array, Array],
    closed: Array,
    states: Sequence[Entry],
    sampled: bool,
    variation: Array | None = None,
) -> Seen:
    """Take hidden modes out of the quotient of a loop, opened with A, B and C, and judge its closed-loop poles.

    `variation` is by how much the entries of the closed matrix change from one period to the next at the operating
    point; None where they do not.
    """
    numerator, denominator, common = coprime(whole.numerator, whole.denominator)
    hidden = judge([root for root in roots(common) if not (sampled and root.is_zero())], closed, sampled, variation)
    visible = judge(roots(numerator + denominator), closed, sampled, variation)
    neutral = [pole for pole in visible if pole.verdict == "marginal"]
    if neutral:
        ends = roots(numerator), roots(denominator)
        for pole in neutral:
            near = [[root for root in end if _is_at(root, pole)] for end in ends]
            if all(near):
                numerator, denominator = _without(numerator, denominator, pole.value)
                visible.remove(pole)
                hidden.append(pole)
                for end, (first, *_) in zip(ends, near, strict=True):
                    end.remove(first)
    verdict, poles = together(visible)
    return Seen(Transfer(numerator, denominator), verdict, poles, tuple(_modes(hidden, opened, states, sampled)))


def _is_at(root: Any, pole: Pole) -> bool:
    return abs(complex(root) - pole.value) <= 2.0 * pole.uncertainty


def _modes(
    hidden: Sequence[Pole], opened: tuple[Array, Array, Array], states: Sequence[Entry], sampled: bool
) -> Iterable[Mode]:
    """Hidden modes that do not decay, each once, a pair as one."""
    lasting = sorted((p for p in hidden if p.verdict != "stable" and p.value.imag >= 0.0), key=lambda p: p.distance)
    for pole in dict.fromkeys(lasting):
        times = lasting.count(pole)
        yield Mode(pole, times, _blocks_of(pole, opened, states, times), sampled)


def _without(numerator: Polynomial, denominator: Polynomial, value: complex) -> tuple[Polynomial, Polynomial]:
    """Both divided by the factors of their zeros next to a place; a pair goes with its upper half."""
    if value.imag < 0.0:
        return numerator, denominator
    quotients = [divmod(flint.fmpq_poly(part), _factor(part, value))[0] for part in (numerator, denominator)]
    below = math.lcm(*(int(quotient.denom()) for quotient in quotients))
    first, second = ((quotient * below).numer() for quotient in quotients)
    return first, second


def _factor(polynomial: Polynomial, value: complex) -> Any:
    """The factor of the zero next to a place, with its numbers cut after some hundred bits."""
    at = min(roots(polynomial), key=lambda root: abs(complex(root) - value))
    if at.imag.is_zero():
        return flint.fmpq_poly([-_fraction(at.real), 1])
    return flint.fmpq_poly([_fraction(at.real) ** 2 + _fraction(at.imag) ** 2, -2 * _fraction(at.real), 1])


def _fraction(ball: Any) -> Any:
    mantissa, exponent = ball.mid().man_exp()
    return flint.fmpq(mantissa * 2**exponent, 1) if exponent >= 0 else flint.fmpq(mantissa, 2 ** int(-exponent))


def _blocks_of(
    pole: Pole, system: tuple[Array, Array, Array], states: Sequence[Entry], multiplicity: int
) -> tuple[str, ...]:
    """Blocks that move in a hidden mode, those that move most first.

    Such a mode moves without being seen, or is not reached: vectors x with (A - p)^m x = 0 and C (A - p)^k x = 0, or
    the same of the transposed system (Popov, Belevitch and Hautus; Kailath, Linear Systems, 6.2).
    """
    a, b, c = system
    alike, scale = balanced(a)
    parts = _unseen(alike, c * scale, pole, multiplicity)
    if not parts.any():
        parts = _unseen(alike.T, (b / scale[:, None]).T, pole, multiplicity)
    if not parts.any():
        return ()
    order = np.argsort(-parts, kind="stable")
    return tuple(dict.fromkeys(states[i][0] for i in order if parts[i] >= 0.1 * parts[order[0]]))


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
