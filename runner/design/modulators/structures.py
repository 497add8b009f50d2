"""Loop filters of sigma-delta modulators: chains of integrators or resonators, with feedback or feed-forward.

State i takes c x_(i-1), minus g x_(i+1) where the pair resonates, plus b_i u, minus a_i v
(feedback, FB); y = c_n x_n + b_(n+1) u. With feed-forward (FF) only the first takes v, by c_1, and
y = a_1 x_1 + ... + a_n x_n + b_(n+1) u. In CIFB and CIFF every integrator delays; a resonator's
poles are 1 +- j sqrt(g). In CRFB and CRFF one of each pair does not, and the poles lie on the unit
circle, at 2 - g = 2 cos w (Schreier and Temes, appendix B). Of continuous time, all integrate over
one period, and the poles are +- j sqrt(g).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import linalg

from proofmass.runner.design.modulators.noise_transfer import NoiseTransfer
from proofmass.runner.host.arrays import Array

FORMS = ("CIFB", "CRFB", "CIFF", "CRFF")
_ALIKE = 1e-6  # by which the gain of a loop of high order is off 1 by rounding


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of a loop filter: a of the quantiser, b of the input, c between states, g of resonators."""

    a: tuple[Any, ...]
    b: tuple[Any, ...]
    c: tuple[Any, ...]
    g: tuple[Any, ...]


@dataclass(frozen=True)
class Structure:
    """A form of loop filter, of discrete time, or of continuous time with a pulse of the converter.

    `pulse` has begin and end of the feedback pulse in periods after the decision, within a period.
    """

    form: str
    order: int
    pulse: tuple[float, float] | None = None

    @property
    def feedback(self) -> bool:
        """The chain has feedback from the quantiser to every state."""
        return self.form.endswith("FB")

    def matrices(self, k: Coefficients) -> tuple[Array, Array]:
        """Return [A B], one row per state, and [C D]; columns are the states, the input u, and the level v."""
        n = self.order
        rows: list[Any] = [None] * n
        unit = np.eye(n + 2, dtype=int).astype(object)
        hold = 0 if self.pulse else 1
        undelayed = self._undelayed()
        for i in [*(i for i in range(n) if i not in undelayed), *undelayed]:
            near = rows if i in undelayed else unit
            row = hold * unit[i] + k.b[i] * unit[n]
            row = row - (k.a[i] * unit[n + 1] if self.feedback else k.c[0] * unit[n + 1] if i == 0 else 0 * unit[i])
            row = row + (k.c[i - self.feedback] * near[i - 1] if i else 0 * unit[i])
            pair, first = divmod(i - n % 2, 2)
            if first == 0 and pair >= 0:
                after = rows[i + 1] if i in undelayed else unit[i + 1]
                row = row - k.g[pair] * after
            rows[i] = row
        if self.feedback:
            last = k.c[-1] * unit[n - 1]
        else:
            last = sum((k.a[i] * unit[i] for i in range(1, n)), k.a[0] * unit[0])
        return np.array(rows), last + k.b[n] * unit[n]

    def stepped(self, k: Coefficients) -> tuple[Array, Array]:
        """Return matrices from sample to sample; in continuous time over the pulse and a hold."""
        rows, last = (part.astype(float) for part in self.matrices(k))
        if self.pulse is None:
            return rows, last
        n, (begin, end) = self.order, self.pulse
        a, b = rows[:, :n], rows[:, n:]
        held = _step(a, b, 1.0)
        pulsed = linalg.expm(a * (1.0 - end)) @ _step(a, b, end - begin)[:, n:]
        return np.column_stack([held[:, : n + 1], pulsed[:, 1]]), last

    def _undelayed(self) -> list[int]:
        """Return the states whose integrators do not delay what comes from other states."""
        if self.pulse or self.form.startswith("CI"):
            return []
        return list(range(1 + (self.order % 2 if self.feedback else 0), self.order, 2))

    def reachable(self, transfer: NoiseTransfer) -> NoiseTransfer:
        """Return a noise transfer function with the zeros that the form has: 1 +- j sqrt(g) where all delay."""
        if self.pulse or self.form.startswith("CR"):
            return transfer
        return NoiseTransfer(tuple(complex(1.0, zero.imag) for zero in transfer.zeros), transfer.poles)

    def resonance(self, angle: float) -> float:
        """Return g for a zero at this angle on the unit circle."""
        if self.pulse:
            return angle * angle
        return 2.0 - 2.0 * math.cos(angle) if self.form.startswith("CR") else math.sin(angle) ** 2

    def signal_gain(self, k: Coefficients, frequency: float) -> float:
        """Return the gain from the input to the level at a frequency, by the rate, while the quantiser has gain 1."""
        rows, last = self.stepped(k)
        n = self.order
        closed = rows[:, :n] + np.outer(rows[:, n + 1], last[:n])
        entry = rows[:, n] + rows[:, n + 1] * last[n]
        z = np.exp(2j * math.pi * frequency)
        return float(abs(last[:n] @ np.linalg.solve(z * np.eye(n) - closed, entry) + last[n]))


def _step(a: Array, b: Array, time: float) -> Array:
    """Return [e^(A t), integral of e^(A s) B ds]: the exponential of [[A, B], [0, 0]] t."""
    n, m = b.shape
    joined = np.zeros((n + m, n + m))
    joined[:n] = np.column_stack([a, b])
    return np.asarray(linalg.expm(joined * time)[:n], dtype=float)


def loop_response(structure: Structure, k: Coefficients, length: int) -> Array:
    """Return samples 1 to `length` of y after one level v = 1 in sample 0: the impulse response of the loop filter."""
    rows, last = structure.stepped(k)
    n = structure.order
    x, values = rows[:, n + 1], []
    for _ in range(length):
        values.append(last[:n] @ x)
        x = rows[:, :n] @ x
    return np.array(values)


def realised(transfer: NoiseTransfer, structure: Structure, feeds: str, centre: float = 0.0) -> Coefficients:
    """Return the coefficients that give a noise transfer function; every c is 1.

    The response of the loop is linear in the a, and n samples of it are its numerator: n equations.
    `feeds` says where the input goes: "first", to the first state alone, with a gain of 1 at the
    `centre` of the band, or "all", by which the signal transfer function is 1.
    """
    n = structure.order
    angles = [abs(float(np.angle(zero))) for zero in transfer.zeros]
    g = tuple(structure.resonance(angle) for angle in angles[n % 2 :: 2])

    def alone(i: int) -> Coefficients:
        one = tuple(float(j == i) for j in range(n))
        return Coefficients(one, (0.0,) * (n + 1), (1.0,) * n, g)

    wanted = structure.reachable(transfer).loop_response(n)
    columns = [loop_response(structure, alone(i), n) for i in range(n)]
    a = tuple(np.linalg.solve(np.array(columns).T, wanted).tolist())
    every = (*(a if structure.feedback else (1.0, *[0.0] * (n - 1))), 1.0)
    k = Coefficients(a, every if feeds == "all" else (every[0], *[0.0] * n), (1.0,) * n, g)
    gain = structure.signal_gain(k, centre) if structure.feedback else 1.0  # with feed-forward it is 1 less the noise's
    if feeds == "all" or abs(gain - 1.0) < _ALIKE:
        return k
    return replace(k, b=(every[0] / gain, *[0.0] * n))


def scaled(structure: Structure, k: Coefficients, swings: Sequence[float]) -> Coefficients:
    """Return the coefficients of the same loop whose states are smaller by these factors."""
    n, s = structure.order, list(swings)
    b = (*(k.b[i] / s[i] for i in range(n)), k.b[n])
    g = tuple(k.g[p] * s[i + 1] / s[i] for p, i in enumerate(range(n % 2, n - 1, 2)))
    if structure.feedback:
        c = (*(k.c[i] * s[i] / s[i + 1] for i in range(n - 1)), k.c[-1] * s[-1])
        return Coefficients(tuple(k.a[i] / s[i] for i in range(n)), b, c, g)
    c = (k.c[0] / s[0], *(k.c[i] * s[i - 1] / s[i] for i in range(1, n)))
    return Coefficients(tuple(k.a[i] * s[i] for i in range(n)), b, c, g)


def named(k: Coefficients, value: Callable[[str], Any]) -> Coefficients:
    """Return the coefficients by `value` of their names, a1 and so on; zeros and ones stay."""
    return Coefficients(
        **{
            letter: tuple(v if v in (0.0, 1.0) else value(f"{letter}{i}") for i, v in enumerate(numbers, 1))
            for letter, numbers in vars(k).items()
        }
    )
