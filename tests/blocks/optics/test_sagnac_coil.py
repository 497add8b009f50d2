"""The coil: Sagnac's phase, and the modulation that comes twice."""

import math

import mpmath
import numpy as np
import pytest

from proofmass.blocks import SagnacCoil
from tests.by_hand.responses import noise, responses


@pytest.mark.parametrize("transit", [1, 3, 50])
def test_phase_of_a_rotation_and_of_a_modulation(transit: int) -> None:
    rotation, modulation = noise(200, 1), noise(200, 2)
    block = SagnacCoil(length=500.0, diameter=0.08, wavelength=1.31e-6, transit=transit)
    late = np.concatenate([np.zeros(transit), modulation])[:200]
    scale = 2.0 * math.pi * 500.0 * 0.08 / (1.31e-6 * 299_792_458.0)
    expected = scale * np.array(rotation) + np.array(modulation) - late
    assert responses(block, "phase", rotation=rotation, modulation=modulation) == pytest.approx(expected, abs=1e-13)


def test_the_scale_is_that_of_area_and_turns() -> None:
    """8 pi N A / (wavelength c) of N turns of area A."""
    turns, area = 1000.0 / (math.pi * 0.1), math.pi * 0.05**2
    (phase,) = responses(SagnacCoil(), "phase", rotation=[1.0], modulation=[0.0])
    assert phase == pytest.approx(8.0 * math.pi * turns * area / (1.55e-6 * 299_792_458.0), rel=1e-14)


def test_at_the_proper_frequency_a_square_wave_doubles() -> None:
    square = [0.25 * math.pi * (1.0 if n % 8 < 4 else -1.0) for n in range(64)]
    answer = responses(SagnacCoil(transit=4), "phase", rotation=[0.0] * 64, modulation=square)
    assert answer[8:] == [2.0 * u for u in square[8:]]


@pytest.mark.derivation(
    SagnacCoil,
    equation="phase = 2 pi L D / (wavelength c) rotation, whatever the index",
    source="special relativity: both waves run after or towards the end of the coil that turns, by mpmath to 40 digits",
    convention="D is the diameter, L the whole fibre, the wavelength that in vacuum; the phase is between both waves",
)
@pytest.mark.parametrize("index", [1.0, 1.468])
def test_two_waves_after_an_end_that_runs(index: float) -> None:
    """Speeds add as (u + v) / (1 + u v / c^2); of 0.2 rad/s the next order is below 1e-15."""
    with mpmath.workdps(40):
        c, length, diameter, wavelength = mpmath.mpf(299_792_458), 800.0, 0.12, 1.55e-6
        rim = 0.2 * mpmath.mpf(diameter) / 2
        along, against = ((c / index + v) / (1 + v / (index * c)) for v in (rim, -rim))
        later = length / (along - rim) - length / (against + rim)
        expected = float(2 * mpmath.pi * c / wavelength * later)
    block = SagnacCoil(length=length, diameter=diameter, wavelength=wavelength)
    assert responses(block, "phase", rotation=[0.2], modulation=[0.0]) == pytest.approx([expected], rel=1e-9)
