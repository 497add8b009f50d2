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
