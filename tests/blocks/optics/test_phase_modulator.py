"""The modulator: half a wave at the half-wave voltage."""

import math

import pytest

from proofmass.blocks import PhaseModulator
from tests.by_hand.responses import response


def test_half_a_wave_at_the_half_wave_voltage() -> None:
    block = PhaseModulator(half_wave_voltage=4.0)
    assert response(block, [4.0, -2.0, 0.0], "phase", "voltage") == pytest.approx([math.pi, -0.5 * math.pi, 0.0])


@pytest.mark.derivation(
    PhaseModulator,
    equation="phase = pi V / half_wave_voltage",
    source="Pockels' effect of lithium niobate, n^3 r V / (2 d) of index, over a length: lambda d / (n^3 r L) is Vpi",
    convention="one arm, one pass; a reset of a whole turn takes twice the half-wave voltage",
)
def test_the_pockels_effect() -> None:
    """r33 = 30.8 pm/V, n = 2.138 at 1.55 um: 4.12 V of 12.5 mm between electrodes 10 um apart."""
    index, pockels, apart, length, wavelength = 2.138, 30.8e-12, 10e-6, 12.5e-3, 1.55e-6
    half_wave = wavelength * apart / (index**3 * pockels * length)
    assert half_wave == pytest.approx(4.12, abs=5e-3)
    volts = [1.3, -2.7, 2.0 * half_wave]
    expected = [2.0 * math.pi / wavelength * length * 0.5 * index**3 * pockels * v / apart for v in volts]
    assert response(PhaseModulator(half_wave_voltage=half_wave), volts, "phase", "voltage") == pytest.approx(expected)
    assert expected[2] == pytest.approx(2.0 * math.pi)
