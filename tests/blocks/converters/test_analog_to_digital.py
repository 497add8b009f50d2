"""The converter against exact rational arithmetic, at every code and every step."""

import math
import random
from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks.converters.analog_to_digital import AnalogToDigital, code, constants
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive
from tests.by_hand.responses import response


def codes(block: AnalogToDigital, voltages: list[float]) -> list[int]:
    c = constants(block, 1.0)
    return [code(c, voltage) for voltage in voltages]


def exact(block: AnalogToDigital, voltage: float) -> int:
    half = 1 << (block.bits - 1)
    volts = (1 + Fraction(block.gain_error)) * Fraction(voltage) + Fraction(block.offset_error)
    return max(-half, min(half - 1, round(volts * half / Fraction(block.reference))))


@pytest.mark.parametrize("reference", [8.0, 10.0])
def test_middle_of_every_code_of_8_bits(reference: float) -> None:
    middles = [reference * n / 128.0 for n in range(-128, 128)]
    assert codes(AnalogToDigital(bits=8, reference=reference), middles) == list(range(-128, 128))


def test_every_step_of_8_bits_to_the_last_digit() -> None:
    """With a reference of a power of two the steps are floats: ties go to the even code."""
    block = AnalogToDigital(bits=8, reference=8.0)
    for n in range(-128, 127):
        step = (n + 0.5) / 16.0
        around = [math.nextafter(step, -math.inf), step, math.nextafter(step, math.inf)]
        assert codes(block, around) == [n, n if n % 2 == 0 else n + 1, n + 1]


def test_steps_with_a_reference_of_10_volts_within_two_last_digits() -> None:
    block = AnalogToDigital(bits=8, reference=10.0)
    for n in range(-128, 127):
        step = (n + 0.5) / 12.8
        assert codes(block, [step - 2.0 * math.ulp(step), step + 2.0 * math.ulp(step)]) == [n, n + 1]


def test_saturation() -> None:
    block = AnalogToDigital(bits=8, reference=8.0)
    assert codes(block, [7.9375, 7.96875, 8.0, 1e6, 1e300]) == [127] * 5
    assert codes(block, [-8.0, -8.03125, -9.0, -1e6, -1e300]) == [-128] * 5


@pytest.mark.parametrize(
    "errors",
    [{}, {"offset_error": 1.3e-3}, {"gain_error": -2e-4}, {"offset_error": -0.5, "gain_error": 0.1}],
)
@pytest.mark.parametrize("reference", [5.0, 4.0])
def test_24_bits_at_random_against_exact_arithmetic(errors: dict[str, float], reference: float) -> None:
    block = AnalogToDigital(bits=24, reference=reference, **errors)
    source = random.Random(24)
    voltages = [source.uniform(-1.2 * reference, 1.2 * reference) for _ in range(3000)]
    assert codes(block, voltages) == [exact(block, voltage) for voltage in voltages]


def test_offset_and_gain_error_by_hand() -> None:
    assert codes(AnalogToDigital(bits=8, reference=8.0, offset_error=0.125), [0.0, 1.0]) == [2, 18]
    assert codes(AnalogToDigital(bits=8, reference=8.0, gain_error=0.5), [0.0, 1.0]) == [0, 24]


def test_both_outputs_are_one_code_and_a_copy_changes_nothing() -> None:
    block = AnalogToDigital(bits=12, reference=10.0)
    rows = drive(block, [{"voltage": 0.37 * n - 9.0} for n in range(50)])
    assert [row["number"] for row in rows] == [row["code"] for row in rows]
    assert {(type(row["code"]), type(row["number"])) for row in rows} == {(int, float)}
    again = codes(block, [row["code"] * 10.0 / 2048.0 for row in rows])
    assert again == [row["code"] for row in rows]


def test_widest_and_narrowest() -> None:
    assert codes(AnalogToDigital(bits=2, reference=1.0), [-1.0, -0.5, 0.0, 0.5, 1.0]) == [-2, -1, 0, 1, 1]
    assert codes(AnalogToDigital(bits=32, reference=1.0), [-1.0, 1.0]) == [-(2**31), 2**31 - 1]
    with pytest.raises(ModelError, match="must be >= 2 and <= 32"):
        AnalogToDigital(bits=33)


@pytest.mark.derivation(
    AnalogToDigital,
    equation="code = clip(rint((gain v + offset) 2^(bits-1) / reference))",
    source="noise of quantising: a step / sqrt(12) rms, so 6.02 bits + 1.76 dB below a sine over the whole span",
    convention="reference is half the span: the step is reference / 2^(bits-1), the span of two references over 2^bits",
)
@pytest.mark.parametrize("bits", [8, 11])
def test_a_sine_over_the_span_against_the_noise_of_quantising(bits: int) -> None:
    count, reference = 8192, 3.0
    volts = reference * (1.0 - 2.0**-bits) * np.sin(2.0 * np.pi * 997.0 * np.arange(count) / count + 0.1)
    code = response(AnalogToDigital(bits=bits, reference=reference), volts.tolist(), "code", "voltage")
    error = np.array(code) * (2.0 * reference / 2**bits) - volts
    ratio = 10.0 * math.log10(np.mean(volts**2) / np.mean(error**2))
    assert ratio == pytest.approx(20.0 * bits * math.log10(2.0) + 10.0 * math.log10(1.5), abs=0.2)
    assert (max(code), min(code)) == (2 ** (bits - 1) - 1, -(2 ** (bits - 1)) + 1)
