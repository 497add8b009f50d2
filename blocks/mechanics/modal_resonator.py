"""Resonator of n modes: m_i (q_i'' + w_i / Q_i q_i' + w_i^2 q_i) = a_i F, displacement = sum of b_i q_i.

w_i = 2 pi frequency_i; a and b are the shapes of the modes where the force acts and where the
motion is read. The step is exact for a force held over a tick (Meirovitch, Fundamentals of
Vibrations, 2001, section 7.15).
"""

import math
from collections.abc import Iterator

from proofmass.blocks.arithmetic.elementary import cosine, exponential, sine
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class ModalResonator(Block):
    """Structure of any number of modes by their frequencies: spurious modes, a beam, a plate, a wine glass."""

    frequencies: tuple[float, ...] = param("Hz", "Resonance of each mode.", default=(1000.0, 2800.0), above=0.0)
    qualities: tuple[float, ...] = param("1", "Quality factor of each mode.", default=(50.0, 80.0), above=0.0)
    masses: tuple[float, ...] = param("kg", "Modal mass of each mode.", default=(1e-8, 1e-8), above=0.0)
    force_shape: tuple[float, ...] = param("1", "Shape of each mode at the force, a.", default=(1.0, 1.0))
    readout_shape: tuple[float, ...] = param("1", "Shape of each mode at the readout, b.", default=(1.0, -1.0))

    force = Input("N", "Force, held over a tick.")

    steps = Buffer("Six numbers a mode: its step.", float, (lambda p: 6 * len(p.frequencies),))
    weights = Buffer("b.", float, ("frequencies",))
    displacements = Buffer("q.", float, ("frequencies",))
    velocities = Buffer("q'.", float, ("frequencies",))


@ModalResonator.requires
def requires(p: ModalResonator) -> Iterator[tuple[str, str]]:
    modes = len(p.frequencies)
    if modes > 64:
        yield "frequencies", "at most 64 numbers"
    for name in ("qualities", "masses", "force_shape", "readout_shape"):
        if len(getattr(p, name)) != modes:
            yield name, f"{modes} numbers, as frequencies has"


@ModalResonator.start
def start(p: ModalResonator, steps: list[float], weights: list[float], period: float) -> None:
    weights[:] = p.readout_shape
    for i in range(len(p.frequencies)):
        w = 2.0 * math.pi * p.frequencies[i]
        c, s = decayed(w, 0.5 * w / p.qualities[i], period)
        d, push = 0.5 * w / p.qualities[i], p.force_shape[i] / p.masses[i]
        steps[6 * i], steps[6 * i + 1], steps[6 * i + 2] = c + d * s, s, push * (1.0 - c - d * s) / (w * w)
        steps[6 * i + 3], steps[6 * i + 4], steps[6 * i + 5] = -w * w * s, c - d * s, push * s


def decayed(w: float, d: float, period: float) -> tuple[float, float]:
    """e^(-d T) cos(r T) and e^(-d T) sin(r T) / r, r^2 = w^2 - d^2; hyperbolic if negative."""
    square = (w - d) * (w + d)
    if abs(square) <= 1e-12 * w * w:
        return exponential(-d * period), period * exponential(-d * period)
    r = math.sqrt(abs(square))
    if square > 0.0:
        fall = exponential(-d * period)
        return fall * cosine(r * period), fall * sine(r * period) / r
    slow, fast = exponential(-w * w / (d + r) * period), exponential(-(d + r) * period)
    return 0.5 * (slow + fast), 0.5 * (slow - fast) / r


@ModalResonator.output("m")
def displacement(p: ModalResonator, weights: list[float], displacements: list[float]) -> float:
    """Displacement where the motion is read."""
    total = 0.0
    for i in range(len(weights)):
        total += weights[i] * displacements[i]
    return total


@ModalResonator.output("m/s")
def velocity(p: ModalResonator, weights: list[float], velocities: list[float]) -> float:
    """Velocity where the motion is read."""
    total = 0.0
    for i in range(len(weights)):
        total += weights[i] * velocities[i]
    return total


@ModalResonator.update
def update(
    p: ModalResonator, steps: list[float], displacements: list[float], velocities: list[float], force: float
) -> None:
    for i in range(len(displacements)):
        q, v = displacements[i], velocities[i]
        displacements[i] = steps[6 * i] * q + steps[6 * i + 1] * v + steps[6 * i + 2] * force
        velocities[i] = steps[6 * i + 3] * q + steps[6 * i + 4] * v + steps[6 * i + 5] * force
