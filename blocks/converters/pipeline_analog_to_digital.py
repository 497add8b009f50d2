"""Pipeline converter of 1.5-bit stages: d = 1, 0, -1 by thresholds +-r / 4, residue' = (1 + e) (2 residue - d r).

r is the reference. After `stages` of them a flash of `last_bits` converts the residue; number = sum
of d_k 2^(bits-1-k) over k from 1 + the last code, bits = stages + last_bits. Thresholds may be off
by r / 4 without a word; a gain error e of stage k makes jumps of e 2^(bits-1-k) steps at its
thresholds (Lewis and Gray, IEEE J. Solid-State Circuits 22, 1987).
"""

import math
from collections.abc import Iterator

from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.arithmetic.rounding import round_half_even, saturated
from proofmass.blocks.declaration.declare import Buffer, Input, param
from proofmass.blocks.parameter_sets.specimen import Specimen

_STREAM = 0x50495045  # "PIPE": no block of noise shares these deviates


class PipelineAnalogToDigital(Specimen):
    """Fast analog-to-digital converter with the errors of its stages: typed, from a file, or drawn for a device."""

    stages: int = param("1", "Stages of a bit and a half.", default=9, at_least=1, at_most=20)
    last_bits: int = param("bit", "Bits of the flash behind them.", default=3, at_least=1, at_most=4)
    reference: float = param("V", "Half the span.", default=1.0, above=0.0)
    gain_errors: tuple[float, ...] = param(
        "1", "Relative error of each residue amplifier, the first first.", default=(0.0,)
    )
    threshold_errors: tuple[float, ...] = param("V", "Added to both thresholds of a stage.", default=(0.0,))
    gain_spread: float = param("1", "Standard deviation of a stage's gain, relative.", default=0.0, at_least=0.0)

    voltage = Input("V", "Voltage to convert.")

    gains = Buffer("Gain of each stage.", float, ("stages",))
    shifts = Buffer("Shift of the thresholds of each stage, over the reference.", float, ("stages",))


@PipelineAnalogToDigital.requires
def requires(p: PipelineAnalogToDigital) -> Iterator[tuple[str, str]]:
    for name, errors in (("gain_errors", p.gain_errors), ("threshold_errors", p.threshold_errors)):
        if len(errors) > p.stages:
            yield name, f"at most {p.stages} numbers, as there are stages"


@PipelineAnalogToDigital.start
def start(p: PipelineAnalogToDigital, gains: list[float], shifts: list[float]) -> None:
    for i in range(p.stages):
        error = p.gain_errors[i] if i < len(p.gain_errors) else 0.0
        gains[i] = 2.0 * (1.0 + error + p.gain_spread * normal_deviate(math.floor(p.device), 0, _STREAM, i))
        shifts[i] = p.threshold_errors[i] / p.reference if i < len(p.threshold_errors) else 0.0


@PipelineAnalogToDigital.output("1")
def number(p: PipelineAnalogToDigital, gains: list[float], shifts: list[float], voltage: float) -> float:
    """Output code as a number, for blocks that compute with numbers."""
    residue, total = voltage / p.reference, 0
    for i in range(len(gains)):
        digit = 1 if residue > 0.25 + shifts[i] else -1 if residue < shifts[i] - 0.25 else 0
        residue = gains[i] * (residue - 0.5 * float(digit))
        total = 2 * total + digit
    steps = float(1 << (p.last_bits - 1))
    half = float(1 << (p.stages + p.last_bits - 1))
    last = saturated(residue * steps, -steps - 1.0, steps + 1.0)
    return round_half_even(saturated(float(total) * steps + last, -half, half - 1.0))


@PipelineAnalogToDigital.output("1")
def code(p: PipelineAnalogToDigital, gains: list[float], shifts: list[float], voltage: float) -> int:
    """Output code, from -2^(bits-1) to 2^(bits-1) - 1."""
    return int(number(p, gains, shifts, voltage))
