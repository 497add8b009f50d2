"""The cavity against bounces of light, fields in time, and figures of Black's introduction."""

import cmath
import math

import numpy as np
import pytest
from scipy import constants as si
from scipy import special

from proofmass.blocks import FabryPerotCavity
from tests.by_hand.responses import responses

C = si.speed_of_light


def answer_of(block: FabryPerotCavity, port: str, detuning: float, power: float) -> float:
    return float(responses(block, port, detuning=[detuning], power=[power])[0])


def bounces(front: float, back: float, length: float, frequency: float) -> complex:
    """Field that comes back, bounce after bounce: -r1 at once, then t1 r2 t1, each more round trip r1 r2 further."""
    r1, r2 = math.sqrt(front), math.sqrt(back)
    trip = cmath.exp(4j * math.pi * frequency * length / C)
    later = r2 * trip * np.sum((r1 * r2 * trip) ** np.arange(4000))
    return complex(-r1 + (1.0 - front) * later)


@pytest.mark.exhaustive(but=2)
@pytest.mark.derivation(
    FabryPerotCavity,
    equation="amplitudes at W of |F E|^2, E = sqrt(P) e^(j depth sin(W t))",
    source="4,000 bounces summed; sidebands of all orders and harmonics of the power by FFTs of the light in time",
    convention="detuning in Hz, not in widths; depth is a peak; the error is a peak, reflected a mean",
)
@pytest.mark.parametrize(("front", "back", "depth"), [(0.99, 0.99, 0.05), (0.98, 0.995, 0.05)])
@pytest.mark.parametrize("detuning", [3e7, 0.0, -2e8, 1.5e9, 6e10])
def test_harmonics_of_light_in_time(front: float, back: float, depth: float, detuning: float) -> None:
    """At a small depth, where sidebands of higher orders are dark."""
    p = FabryPerotCavity(
        length=1e-3, front_reflectivity=front, back_reflectivity=back, modulation_frequency=2e9, modulation_depth=depth
    )
    turns = np.arange(64) / 64.0
    lines = np.fft.fft(np.exp(1j * depth * np.sin(2.0 * np.pi * turns))) / 64.0
    orders = np.fft.fftfreq(64, 1.0 / 64.0)
    answers = [bounces(front, back, 1e-3, detuning + 2e9 * k) for k in orders]
    power = np.abs(np.fft.ifft(lines * answers) * 64.0) ** 2
    harmonics = np.fft.fft(power) / 64.0
    found = [answer_of(p, port, detuning=detuning, power=1e-3) for port in ("reflected", "error")]
    expected = [harmonics[0].real, -2.0 * harmonics[1].imag]
    assert found == pytest.approx([1e-3 * value for value in expected], rel=3e-3, abs=1e-9)


def test_airy_and_finesse() -> None:
    """Without modulation: nothing comes back at resonance, half of it at c / (4 L F), F = pi r / (1 - r^2)."""
    p = FabryPerotCavity(length=0.05, front_reflectivity=0.999, back_reflectivity=0.999, modulation_depth=0.0)
    finesse = math.pi * math.sqrt(0.999) / 0.001
    for factor, part in ((0.0, 0.0), (1.0, 0.5), (3.0, 0.9)):
        detuning = factor * C / (4.0 * 0.05 * finesse)
        assert answer_of(p, "reflected", detuning=detuning, power=1.0) == pytest.approx(part, abs=1e-5)
    assert answer_of(p, "reflected", detuning=C / 0.1, power=1.0) == pytest.approx(0.0, abs=1e-9)


def test_slope_and_shot_noise_of_black() -> None:
    """Black's eq. 4.1 and 4.6: -8 sqrt(Pc Ps) per width, and 8.1e-21 m/sqrt(Hz) at finesse 1e4, 1064 nm, 500 mW."""
    finesse, length, depth = 1e4, 0.1, 0.3
    reflectivity = 1.0 - math.pi / finesse
    p = FabryPerotCavity(
        length=length,
        front_reflectivity=reflectivity,
        back_reflectivity=reflectivity,
        modulation_frequency=50e6,
        modulation_depth=depth,
    )
    carrier, side = special.jv(0, depth) ** 2, special.jv(1, depth) ** 2
    power = 0.5 / carrier
    width = C / (2.0 * length * finesse)
    slope = answer_of(p, "error", detuning=1.0, power=power) - answer_of(p, "error", detuning=-1.0, power=power)
    assert slope / 2.0 == pytest.approx(-8.0 * math.sqrt(carrier * side) * power / width, rel=1e-3)
    light = answer_of(p, "reflected", detuning=0.0, power=power)
    assert light == pytest.approx(2.0 * side * power, rel=1e-3)
    noise = math.sqrt(2.0 * si.h * C / 1064e-9 * light)  # as Black has it, of the mean power in the band of the mixer
    assert noise / abs(slope / 2.0) * length * 1064e-9 / C == pytest.approx(8.1e-21, rel=0.01)
