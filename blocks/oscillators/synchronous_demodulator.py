"""Synchronous demodulator: i = 2 / N sum of s sin, q = 2 / N sum of s cos over N ticks: matched to a carrier.

Of s = A sin(f + d) and references sin(f), cos(f) it gives i = A cos(d), q = A sin(d), without
ripple where N ticks are whole periods. White noise of s comes through with sqrt(2 / N) of its
deviation (Proakis, Digital Communications, section 4.2).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class SynchronousDemodulator(Block):
    """Both components of a carrier, averaged over whole periods and given once in `ratio` ticks."""

    ratio: int = param("1", "Ticks of an average, N: whole periods.", default=25, at_least=1, at_most=1_000_000_000)
    initial_in_phase: float = param("{unit}", "Component along the sine until then.", default=0.0)
    unit: str = param("", "Unit of signal and components.", default="V")

    signal = Input("{unit}", "The carrier.")
    sine = Input("1", "Reference in phase, of amplitude 1.")
    cosine = Input("1", "Reference in quadrature, of amplitude 1.")


class State(NamedTuple):
    filled: int
    along_sine: float
    along_cosine: float
    in_phase: float
    quadrature: float


@SynchronousDemodulator.start
def start(p: SynchronousDemodulator) -> State:
    return State(0, 0.0, 0.0, p.initial_in_phase, 0.0)


@SynchronousDemodulator.output("{unit}", every="ratio")
def in_phase(p: SynchronousDemodulator, x: State) -> float:
    """Component along the sine, of the last whole average."""
    return x.in_phase


@SynchronousDemodulator.output("{unit}", every="ratio")
def quadrature(p: SynchronousDemodulator, x: State) -> float:
    """Component along the cosine, of the last whole average."""
    return x.quadrature


@SynchronousDemodulator.update
def update(p: SynchronousDemodulator, x: State, signal: float, sine: float, cosine: float) -> State:
    filled, i, q = x.filled + 1, x.along_sine + signal * sine, x.along_cosine + signal * cosine
    if filled == p.ratio:
        scale = 2.0 / float(p.ratio)
        return State(0, 0.0, 0.0, scale * i, scale * q)
    return State(filled, i, q, x.in_phase, x.quadrature)
