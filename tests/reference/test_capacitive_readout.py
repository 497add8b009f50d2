"""The capacitive readout at the level of its carrier against one gain and its low-pass, and against formulas."""

import math

import numpy as np
import pytest

from docs.papers.pn_runs import library
from proofmass.runner.run.simulate import simulate

CARRIER, CORNER, RC = 2.0 * math.pi * 100e3, 2.0 * math.pi * 20e3, 1e-5
TONE = 2.0 * math.pi * 1e3


def fundamentals(amplitude: float) -> tuple[complex, complex]:
    """Of the means over periods of the carrier, demodulated and of the gain model, in the second millisecond."""
    graph = library("capacitive_readout.toml").with_parameters({"displacement.amplitude": amplitude})
    result = simulate(graph, engine="compiled")
    turned = np.exp(-1j * TONE * 1e-5 * np.arange(101, 201))
    first, second = (2.0 * np.mean(result[name].values[101:201] * turned) for name in NAMES)
    return complex(first), complex(second)


NAMES = ("demodulated.mean", "modelled.mean")


def test_20_nanometres_against_the_gain_model() -> None:
    """0.7e-4 in amplitude, of the pair; the amplifier delays the envelope by RC / (1 + (w RC)^2), as no gain does."""
    found, model = fundamentals(20e-9)
    assert abs(found) / abs(model) - 1.0 == pytest.approx(0.75e-4, abs=5e-6)
    delay = RC / (1.0 + (CARRIER * RC) ** 2)
    assert delay == pytest.approx(0.247e-6, rel=1e-2)
    assert np.angle(model / found) == pytest.approx(TONE * delay, rel=2e-2)


def test_200_nanometres_show_the_cubic_of_the_pair() -> None:
    """x / (1 - x^2) with x = 0.1 sin: 1 + 3/4 x^2 + 5/8 x^4 in its fundamental."""
    found, model = fundamentals(200e-9)
    assert abs(found) / abs(model) - 1.0 == pytest.approx(0.0075 + 0.625e-4, abs=1e-4)


def test_the_gain_model_against_its_formula() -> None:
    """3.530e8 V/m, behind a Butterworth low-pass, and the mean over the 64 ticks before."""
    _, model = fundamentals(20e-9)
    s = 1j * TONE
    low_pass = 1.0 / (1.0 + math.sqrt(2.0) * s / CORNER + (s / CORNER) ** 2)
    mean = np.mean(np.exp(-s * np.arange(1, 65) / 6.4e6))
    assert model == pytest.approx(-1j * 20e-9 * 3.5301e8 * low_pass * mean, rel=1e-5)
    slope = 2.0 * 1.3e-12 / 2e-6 / 1e-12 * 274.965 / math.sqrt(1.0 + (CARRIER * RC) ** -2)
    assert slope == pytest.approx(3.5301e8, rel=1e-4)
