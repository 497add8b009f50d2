"""The demodulator: both components of a carrier, and its filters against scipy.signal."""

import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import InPhaseQuadratureDemodulator
from tests.by_hand.functions import drive
from tests.by_hand.responses import distance, noise

PERIOD = 1e-5


def demodulated(carrier: list[float], frequency: float, corner: float) -> tuple[np.ndarray, np.ndarray]:
    phases = [2.0 * math.pi * frequency * PERIOD * n for n in range(len(carrier))]
    rows = drive(
        InPhaseQuadratureDemodulator(corner_frequency=corner),
        [{"signal": u, "sine": math.sin(f), "cosine": math.cos(f)} for u, f in zip(carrier, phases, strict=True)],
        PERIOD,
    )
    return tuple(np.array([row[name] for row in rows]) for name in ("in_phase", "quadrature"))  # type: ignore[return-value]


@pytest.mark.parametrize("lead", [0.0, 0.7, -2.0])
def test_components_of_a_carrier(lead: float) -> None:
    carrier = [1.5 * math.sin(2.0 * math.pi * 8000.0 * PERIOD * n + lead) for n in range(20_000)]
    i, q = demodulated(carrier, 8000.0, 100.0)
    assert np.mean(i[-5000:]) == pytest.approx(1.5 * math.cos(lead), abs=1e-3)
    assert np.mean(q[-5000:]) == pytest.approx(1.5 * math.sin(lead), abs=1e-3)


def test_its_filters_against_scipy() -> None:
    u = np.array(noise(2000))
    phases = 2.0 * np.pi * 8000.0 * PERIOD * np.arange(2000)
    sections = signal.butter(2, 300.0, fs=1.0 / PERIOD, output="sos")
    i, q = demodulated(u.tolist(), 8000.0, 300.0)
    assert distance(i, signal.sosfilt(sections, 2.0 * u * np.sin(phases))) < 1e-11
    assert distance(q, signal.sosfilt(sections, 2.0 * u * np.cos(phases))) < 1e-11


@pytest.mark.exhaustive
@pytest.mark.derivation(
    InPhaseQuadratureDemodulator,
    equation="i, q = low-pass of 2 u sine, 2 u cosine",
    source="two side tones of a carrier, one above and one below, at the corner: half of their power is left",
    convention="i and q are peaks, 1 for a carrier of 1; q leads by a quarter turn; the corner is that of -3.01 dB",
)
def test_side_tones_at_the_corner() -> None:
    """u = (3 + 0.6 cos m) sin(f + 0.5) + 0.4 sin m cos(f + 0.5): swings of 0.6 and 0.4 at the corner."""
    n = 40_000
    carrier, modulation = (2.0 * math.pi * f * PERIOD * np.arange(n) for f in (12_500.0, 100.0))
    u = (3.0 + 0.6 * np.cos(modulation)) * np.sin(carrier + 0.5) + 0.4 * np.sin(modulation) * np.cos(carrier + 0.5)
    i, q = demodulated(u.tolist(), 12_500.0, 100.0)
    whole = (i + 1j * q)[-n // 2 :] * np.exp(-0.5j)
    lines = np.fft.fft(whole) / len(whole)
    swing = 100 * len(whole) // 100_000
    along, across = lines[swing] + np.conj(lines[-swing]), lines[swing] - np.conj(lines[-swing])
    assert lines[0] == pytest.approx(3.0, rel=1e-4)
    assert (abs(along), abs(across)) == pytest.approx((0.6 / math.sqrt(2.0), 0.4 / math.sqrt(2.0)), rel=1e-3)
