"""The modulator: half a wave at the half-wave voltage."""

import math

import pytest

from proofmass.blocks import PhaseModulator
from tests.by_hand.responses import response


def test_half_a_wave_at_the_half_wave_voltage() -> None:
    block = PhaseModulator(half_wave_voltage=4.0)
    assert response(block, [4.0, -2.0, 0.0], "phase", "voltage") == pytest.approx([math.pi, -0.5 * math.pi, 0.0])
