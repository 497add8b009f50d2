"""I/Q demodulator: i = low-pass of 2 u sine, q = low-pass of 2 u cosine, Butterworth filters of order 2.

Of u = A sin(f + d) and references sin(f), cos(f): i = A cos(d), q = A sin(d) (Oppenheim and
Schafer, section 12.4).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.sections import warped
from proofmass.blocks.declaration.declare import Block, Input, param

ROOT = 1.4142135623730951  # of 2: 1 / quality


class InPhaseQuadratureDemodulator(Block):
    """Coherent demodulator: both components of a carrier; Magnitude and ArcTangent2 go on."""

    corner_frequency: float = param("Hz", "Corner of the low-pass filters.", default=100.0, above=0.0)
    unit: str = param("", "Unit of signal and components.", default="1")

    signal = Input("{unit}", "The carrier.")
    sine = Input("1", "Reference in phase, of amplitude 1.")
    cosine = Input("1", "Reference in quadrature, of amplitude 1.")


class State(NamedTuple):
    i1: float
    i2: float
    q1: float
    q2: float


class Constants(NamedTuple):
    b0: float  # with the factor 2 of the mixer
    a1: float
    a2: float


@InPhaseQuadratureDemodulator.constants
def constants(p: InPhaseQuadratureDemodulator, period: float) -> Constants:
    k = warped(p.corner_frequency, period)
    scale = 1.0 / (1.0 + ROOT * k + k * k)
    return Constants(2.0 * k * k * scale, 2.0 * (k * k - 1.0) * scale, (1.0 - ROOT * k + k * k) * scale)


@InPhaseQuadratureDemodulator.output("{unit}")
def in_phase(c: Constants, x: State, signal: float, sine: float) -> float:
    """Component along the sine."""
    return c.b0 * (signal * sine) + x.i1


@InPhaseQuadratureDemodulator.output("{unit}")
def quadrature(c: Constants, x: State, signal: float, cosine: float) -> float:
    """Component along the cosine."""
    return c.b0 * (signal * cosine) + x.q1


@InPhaseQuadratureDemodulator.update
def update(c: Constants, x: State, signal: float, sine: float, cosine: float) -> State:
    u, v = c.b0 * (signal * sine), c.b0 * (signal * cosine)
    i, q = u + x.i1, v + x.q1
    return State(2.0 * u - c.a1 * i + x.i2, u - c.a2 * i, 2.0 * v - c.a1 * q + x.q2, v - c.a2 * q)
