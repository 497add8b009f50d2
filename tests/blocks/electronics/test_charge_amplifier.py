"""The charge amplifier against its transfer function."""

import math

import pytest

from proofmass.blocks.electronics.charge_amplifier import ChargeAmplifier, State, derivative, voltage


def response(p: ChargeAmplifier, s: complex) -> complex:
    """Voltage over charge, from the state equation: rest' = a rest + b q, v = rest + d q."""
    a, b, d = derivative(p, State(1.0), 0.0).rest, derivative(p, State(0.0), 1.0).rest, voltage(p, State(0.0), 1.0)
    return b / (s - a) + d


@pytest.mark.parametrize("frequency", [10.0, 15.9e3, 100e3, 10e6])
def test_transimpedance(frequency: float) -> None:
    p, s = ChargeAmplifier(), 2j * math.pi * frequency
    expected = -s * 10e6 / (1.0 + s * 10e6 * 1e-12)
    assert response(p, s) == pytest.approx(expected, rel=1e-9)


def test_at_the_carrier_it_turns_the_phase_by_nine_degrees() -> None:
    """1.3 uF/m, 1 V at 100 kHz: 1.2838 V/um, 98.8 % of what the capacitor alone would give."""
    found = response(ChargeAmplifier(), 2j * math.pi * 100e3)
    assert 1.3e-6 * abs(found) == pytest.approx(1.2838e6, rel=1e-4)
    assert math.degrees(math.atan2(-found.imag, -found.real)) == pytest.approx(9.043, abs=1e-3)


def test_there_is_feedthrough() -> None:
    assert ChargeAmplifier.feedthrough("voltage") == ("charge",)
    assert ChargeAmplifier.continuous()
