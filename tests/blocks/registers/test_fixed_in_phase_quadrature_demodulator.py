"""The demodulator against exact fractions, and against the one in floating point."""

import math
from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks import FixedInPhaseQuadratureDemodulator, InPhaseQuadratureDemodulator
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.responses import responses

SIGNAL, REFERENCE, STATE, OUT, PERIOD = Fixed(16, 12), Fixed(16, 14), Fixed(34, 28), Fixed(18, 14), 1e-4


@pytest.mark.exhaustive("toward_zero")
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_fractions(rounding: str) -> None:
    block = FixedInPhaseQuadratureDemodulator(rounding=rounding)
    k = math.tan(math.pi * 100.0 * PERIOD)
    scale = 1.0 / (1.0 + math.sqrt(2.0) * k + k * k)
    values = 2.0 * k * k * scale, 2.0 * (k * k - 1.0) * scale, (1.0 - math.sqrt(2.0) * k + k * k) * scale
    b0, a1, a2 = (Fraction(round(v * 2**22), 2**22) for v in values)

    def low_pass(products: list[Fraction]) -> list[int]:
        first = second = Fraction(0)
        found = []
        for product in products:
            u = b0 * product
            y = value_of(cast(u + first, STATE, rounding, "saturate"), STATE)
            found.append(cast(y, OUT, rounding, "saturate"))
            first = value_of(cast(2 * u - a1 * y + second, STATE, rounding, "saturate"), STATE)
            second = value_of(cast(u - a2 * y, STATE, rounding, "saturate"), STATE)
        return found

    carrier, sine, cosine = words(SIGNAL, 300), words(REFERENCE, 300, seed=2), words(REFERENCE, 300, seed=3)
    rows = drive_fixed(
        block,
        [{"signal": u, "sine": s, "cosine": c} for u, s, c in zip(carrier, sine, cosine, strict=True)],
        PERIOD,
    )
    for name, reference in (("in_phase", sine), ("quadrature", cosine)):
        products = [value_of(u, SIGNAL) * value_of(r, REFERENCE) for u, r in zip(carrier, reference, strict=True)]
        assert [row[name] for row in rows] == low_pass(products)


@pytest.mark.exhaustive
def test_a_carrier_as_in_floating_point() -> None:
    angle = 2.0 * np.pi * 0.11 * np.arange(1500)
    floats = {"signal": 0.7 * np.sin(angle + 0.4), "sine": np.sin(angle), "cosine": np.cos(angle)}
    steps = {"signal": 2.0**12, "sine": 2.0**14, "cosine": 2.0**14}
    held = {name: np.round(values * steps[name]).astype(int) for name, values in floats.items()}
    rows = [{name: int(values[n]) for name, values in held.items()} for n in range(1500)]
    found = drive_fixed(FixedInPhaseQuadratureDemodulator(), rows, PERIOD)
    signals = {name: (values / steps[name]).tolist() for name, values in held.items()}
    for output in ("in_phase", "quadrature"):
        expected = responses(InPhaseQuadratureDemodulator(), output, PERIOD, **signals)
        assert [row[output] / 2**14 for row in found] == pytest.approx(expected, abs=3e-4)
    assert found[-1]["in_phase"] / 2**14 == pytest.approx(0.7 * math.cos(0.4), abs=0.01)
