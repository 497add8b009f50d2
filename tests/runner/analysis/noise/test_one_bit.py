"""Quantisers of one bit in a budget, against closed forms of Gaussian inputs and programs of their own."""

import math

import numpy as np
import pytest
import scipy.optimize
import scipy.signal

from proofmass import Graph, linearise, noise
from proofmass.blocks import Comparator, Constant, Difference, Gain, SigmaDeltaModulator, Sum, UnitDelay, WhiteNoise

RATE = 1e6


def modulator(gains: tuple[float, ...], feedback: tuple[float, ...], dither: float, level: float = 0.0) -> Graph:
    """A modulator of two levels with a constant and white noise of an rms."""
    return Graph(
        name="",
        rate=RATE,
        seed=1,
        blocks={
            "dither": WhiteNoise(density=dither * math.sqrt(2.0 / RATE), unit="V"),
            "level": Constant(value=level, unit="V"),
            "sum": Sum(unit="V"),
            "modulator": SigmaDeltaModulator(gains=gains, feedback=feedback),
        },
        wires=["dither.output -> sum.first", "level.output -> sum.second", "sum.output -> modulator.input"],
        probes=["modulator.output"],
    )


def test_gaussian_input_has_the_gain_of_its_closed_form() -> None:
    """x' = x + g (0 - v), v the sign of x + n: K sigma = sqrt(2 / pi), and the error has 1 - 2 / pi.

    Without n that is g K = 4 / pi, whatever g is.
    """
    g, rms = 0.2, 1.0
    error = 1.0 - 2.0 / math.pi

    def apart(k: float) -> float:
        inside = g * g * (error + k * k * rms * rms) / (2.0 * g * k - (g * k) ** 2)
        return k * math.sqrt(inside + rms * rms) - math.sqrt(2.0 / math.pi)

    gain = scipy.optimize.brentq(apart, 1e-3, 1.9 / g)
    lone = 4.0 / math.pi / g
    assert lone * lone * g * g * error / (2.0 * g * lone - (g * lone) ** 2) == pytest.approx(2.0 / math.pi)
    graph = Graph(
        name="",
        rate=RATE,
        seed=3,
        blocks={
            "dither": WhiteNoise(density=rms * math.sqrt(2.0 / RATE)),
            "noisy": Sum(),
            "bit": Comparator(),
            "loss": Gain(gain=g),
            "held": UnitDelay(),
            "apart": Difference(),
        },
        wires=[
            "held.output -> noisy.first",
            "dither.output -> noisy.second",
            "noisy.output -> bit.input",
            "bit.sign -> loss.input",
            "held.output -> apart.first",
            "loss.output -> apart.second",
            "apart.output -> held.input",
        ],
        probes=["held.output"],
    )
    budget = noise(graph, "held.output")
    inside = g * g * (error + gain * gain * rms * rms) / (2.0 * g * gain - (g * gain) ** 2)
    assert budget.rms == pytest.approx(math.sqrt(inside), rel=0.02)
    assert {source.block: source.kind for source in budget.sources} == {
        "bit": "one-bit quantisation",
        "dither": "WhiteNoise",
    }
    assert f"bit: one bit counts as a gain of {gain:.1g}" in budget.notes[-1]


@pytest.mark.parametrize(("dither", "level"), [(0.3, 0.1), (0.05, 0.01)])
def test_noise_in_the_band_of_a_second_order(dither: float, level: float) -> None:
    """The power that a program of its own has in the band, within half a dB."""
    top, values = RATE / 100.0, 1 << 17
    budget = noise(modulator((1.0, 1.0), (1.0, 2.0), dither, level), "modulator.output", band=(200.0, top))
    entry = level + dither * np.random.default_rng(5).normal(size=values)
    a = b = 0.0
    bits = np.empty(values)
    for n, u in enumerate(entry.tolist()):
        v = 1.0 if b >= 0.0 else -1.0
        bits[n] = v
        a, b = a + u - v, b + a - 2.0 * v
    f, density = scipy.signal.welch(bits, RATE, nperseg=1 << 13)
    inside = (f >= 200.0) & (f <= top)
    power = float(np.sum(density[inside])) * (f[1] - f[0])
    assert 20.0 * math.log10(budget.rms) == pytest.approx(10.0 * math.log10(power), abs=0.5)


def test_error_that_repeats_itself_is_told() -> None:
    budget = noise(modulator((1.0,), (1.0,), 1e-9, 0.1), "modulator.output")
    assert "is not white" in budget.notes[-1]
    steady = noise(modulator((1.0,), (1.0,), 0.4, 0.1), "modulator.output")
    assert "is not white" not in steady.notes[-1]


@pytest.mark.parametrize("level", [-0.4, 0.4])
@pytest.mark.defect("S29", before="in the upper half of its range a modulator had no slope", after="has that of a gain")
def test_slope_of_a_modulator_on_both_sides_of_the_middle(level: float) -> None:
    graph = modulator((0.2,), (1.0,), 0.0, level)
    poles = linearise(graph, ["level.output"], ["modulator.output"], at="10 us").poles()
    assert float(poles[0].real) == pytest.approx(0.8)
