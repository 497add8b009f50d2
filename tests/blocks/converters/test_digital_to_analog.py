"""The converter against exact rational arithmetic, at every code."""

import math
import random
from fractions import Fraction
from typing import Any

import pytest

from proofmass.blocks import DigitalToAnalog
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive
from tests.by_hand.ladder import ladder


def rows(block: DigitalToAnalog, numbers: list[float]) -> list[dict[str, Any]]:
    return drive(block, [{"number": number} for number in numbers])


@pytest.mark.parametrize("reference", [2.5, 4.0, 1.0 / 3.0])
def test_voltage_of_every_code_of_8_bits_is_the_nearest_float(reference: float) -> None:
    block = DigitalToAnalog(bits=8, reference=reference)
    for n, row in zip(range(-128, 128), rows(block, [float(n) for n in range(-128, 128)]), strict=True):
        assert row["code"] == n
        assert row["voltage"] == float(n * Fraction(reference) / 128)


def test_rounding_at_every_step_of_8_bits() -> None:
    for n in range(-128, 127):
        step = n + 0.5
        around = [math.nextafter(step, -math.inf), step, math.nextafter(step, math.inf)]
        found = [row["code"] for row in rows(DigitalToAnalog(bits=8), around)]
        assert found == [n, n if n % 2 == 0 else n + 1, n + 1]


def test_saturation() -> None:
    found = rows(DigitalToAnalog(bits=8, reference=2.0), [127.0, 127.5, 128.0, 1e300, -128.0, -128.5, -1e300])
    assert [row["code"] for row in found] == [127] * 4 + [-128] * 3
    assert [row["voltage"] for row in found] == [1.984375] * 4 + [-2.0] * 3


def test_20_bits_at_random_against_exact_arithmetic() -> None:
    source = random.Random(20)
    numbers = [source.uniform(-6e5, 6e5) for _ in range(3000)]
    for number, row in zip(numbers, rows(DigitalToAnalog(), numbers), strict=True):
        expected = max(-(2**19), min(2**19 - 1, round(Fraction(number))))
        assert row["code"] == expected
        assert row["voltage"] == float(expected * Fraction(5, 2) / 2**19)


def test_the_reference_may_be_driven_and_the_resolution_not() -> None:
    assert DigitalToAnalog.drivable("reference")
    assert not DigitalToAnalog.drivable("bits")
    with pytest.raises(ModelError, match="must be > 0"):
        DigitalToAnalog(reference=0.0)


@pytest.mark.derivation(
    DigitalToAnalog,
    equation="voltage = clip(rint(number)) reference / 2^(bits-1)",
    source="R-2R ladder in offset binary between -reference and reference, by Kirchhoff's laws",
    convention="reference is half the span, the voltage of the code 2^(bits-1), one step above the highest",
)
def test_an_r_2r_ladder_between_two_references() -> None:
    codes = [-128, -127, -1, 0, 1, 77, 127]
    expected = [ladder(8, code + 128, 3.3, -3.3) for code in codes]
    found = [row["voltage"] for row in rows(DigitalToAnalog(bits=8, reference=3.3), [float(code) for code in codes])]
    assert found == pytest.approx(expected, abs=1e-14)
