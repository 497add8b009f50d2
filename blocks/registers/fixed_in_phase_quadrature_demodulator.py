"""I/Q demodulator in registers: i = low-pass of 2 u sine, q = low-pass of 2 u cosine, Butterworth filters of order 2.

The twin of an InPhaseQuadratureDemodulator: each product is exact, and so is the sum of a filter in
direct form II transposed; states and outputs are rounded once (Oppenheim and Schafer, Discrete-Time
Signal Processing, section 6.9).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.arithmetic.sections import warped
from proofmass.blocks.declaration.declare import Block, Input, param

ROOT = 1.4142135623730951  # of 2: 1 / quality


class FixedInPhaseQuadratureDemodulator(Block):
    """Coherent demodulator in fixed point, of the sine and cosine of a FixedSineTable; FixedCordicVectoring goes on."""

    corner_frequency: float = param("Hz", "Corner of the low-pass filters.", default=100.0, above=0.0)
    signal_format: Fixed = param("1", "Format of the signal.", default=Fixed(16, 12))
    reference_format: Fixed = param("1", "Format of sine and cosine.", default=Fixed(16, 14))
    coefficient_format: Fixed = param("1", "Format of the filters' coefficients.", default=Fixed(24, 22))
    state_format: Fixed = param("1", "Format of the filters' states.", default=Fixed(34, 28))
    output_format: Fixed = param("1", "Format of both components.", default=Fixed(18, 14))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of states and outputs.", default="saturate")
    unit: str = param("", "Unit of signal and components.", default="1")

    signal = Input("{unit}", "The carrier.", dtype=FixedValue)
    sine = Input("1", "Reference in phase, of amplitude 1.", dtype=FixedValue)
    cosine = Input("1", "Reference in quadrature, of amplitude 1.", dtype=FixedValue)


class State(NamedTuple):
    i1: FixedValue
    i2: FixedValue
    q1: FixedValue
    q2: FixedValue


class Constants(NamedTuple):
    b0: FixedValue  # with the factor 2 of the mixer
    a1: FixedValue
    a2: FixedValue


@FixedInPhaseQuadratureDemodulator.formats
def formats(p: FixedInPhaseQuadratureDemodulator) -> dict[str, Fixed]:
    inputs = {"signal": p.signal_format, "sine": p.reference_format, "cosine": p.reference_format}
    outputs = {"in_phase": p.output_format, "quadrature": p.output_format}
    return inputs | outputs | {"c": p.coefficient_format, "x": p.state_format}


@FixedInPhaseQuadratureDemodulator.constants
def constants(p: FixedInPhaseQuadratureDemodulator, period: float) -> Constants:
    k = warped(p.corner_frequency, period)
    scale = 1.0 / (1.0 + ROOT * k + k * k)
    values = 2.0 * k * k * scale, 2.0 * (k * k - 1.0) * scale, (1.0 - ROOT * k + k * k) * scale
    return Constants(*(fixed(value, p.coefficient_format, "half_even") for value in values))


def filtered(
    c: Constants, p: FixedInPhaseQuadratureDemodulator, first: FixedValue, signal: FixedValue, reference: FixedValue
) -> FixedValue:
    """Output of a filter, in the format of its states."""
    return (c.b0 * (signal * reference) + first).to(p.state_format, p.rounding, p.overflow)


@FixedInPhaseQuadratureDemodulator.output("{unit}")
def in_phase(
    c: Constants, p: FixedInPhaseQuadratureDemodulator, x: State, signal: FixedValue, sine: FixedValue
) -> FixedValue:
    """Component along the sine."""
    return filtered(c, p, x.i1, signal, sine).to(p.output_format, p.rounding, p.overflow)


@FixedInPhaseQuadratureDemodulator.output("{unit}")
def quadrature(
    c: Constants, p: FixedInPhaseQuadratureDemodulator, x: State, signal: FixedValue, cosine: FixedValue
) -> FixedValue:
    """Component along the cosine."""
    return filtered(c, p, x.q1, signal, cosine).to(p.output_format, p.rounding, p.overflow)


@FixedInPhaseQuadratureDemodulator.update
def update(
    c: Constants, p: FixedInPhaseQuadratureDemodulator, x: State, signal: FixedValue, sine: FixedValue,
    cosine: FixedValue,
) -> State:  # fmt: skip
    u, v = c.b0 * (signal * sine), c.b0 * (signal * cosine)
    i, q = filtered(c, p, x.i1, signal, sine), filtered(c, p, x.q1, signal, cosine)
    states = 2 * u - c.a1 * i + x.i2, u - c.a2 * i, 2 * v - c.a1 * q + x.q2, v - c.a2 * q
    return State(*(state.to(p.state_format, p.rounding, p.overflow) for state in states))
