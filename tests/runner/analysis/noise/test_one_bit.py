"""Quantisers of one bit in a budget, against closed forms of Gaussian inputs and programs of their own."""

import itertools
import math

import numpy as np
import pytest
import scipy.optimize
import scipy.signal

from proofmass import Graph, ModelError, linearise, noise, simulate
from proofmass.blocks import (
    Comparator,
    Constant,
    Decimator,
    Difference,
    Gain,
    LowPass,
    SigmaDeltaModulator,
    Sum,
    UnitDelay,
    WhiteNoise,
)
from proofmass.runner.analysis.decisions.compiled_decisions import SETTLING, compiled_runs
from proofmass.runner.analysis.decisions.watched import Watched
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan

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


def locked(density: float) -> Graph:
    """A low-pass behind a comparator: it goes round in a limit cycle that little noise does not move."""
    return Graph(
        name="",
        rate="1 kHz",
        duration="4 s",
        blocks={
            "n": WhiteNoise(density=density),
            "e": Difference(),
            "bit": Comparator(),
            "plant": LowPass(corner_frequency=20.0),
            "mean": Decimator(ratio=10),
        },
        wires=[
            *("n.output -> e.first", "plant.output -> e.second", "e.output -> bit.input"),
            *("bit.sign -> plant.input", "bit.sign -> mean.input"),
        ],
        probes=["bit.sign", "mean.mean"],
    )


@pytest.mark.exhaustive
@pytest.mark.defect("S560", before="rms 0.0150 behind a loop locked in its limit cycle", after="no noise, and why")
def test_noise_does_not_pass_a_bit_in_a_limit_cycle() -> None:
    first, second = (simulate(locked(1e-4), seed=seed)["bit.sign"].values[2000:] for seed in (1, 2))
    turns = [k for k in range(1, 40) if np.array_equal(first[k:], second[:-k])]
    assert turns, "the cycle of a run is that of another, at another phase"
    for output in ("bit.sign", "mean.mean"):
        with pytest.raises(ModelError, match="no noise reaches") as caught:
            noise(locked(1e-4), output)
        assert "the loop is locked" in caught.value.problems[0].hint
    through = noise(locked(1e-4), "e.output")
    assert through.rms == pytest.approx(1e-4 * math.sqrt(500.0), rel=1e-9)
    assert any("locked" in note for note in through.notes) or through.sources[0].share == 1.0
    assert noise(locked(0.02), "bit.sign").rms > 0.1


@pytest.mark.exhaustive
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


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("gains", "feedback", "dither", "level"),
    [
        ((1.0, 1.0), (1.0, 2.0), 0.05, 0.01),
        pytest.param((0.044, 0.2881, 0.7997), (1.0, 1.0, 1.0), 0.3, 0.1, marks=pytest.mark.exhaustive),
    ],
)
@pytest.mark.defect("S94", before="by up to 5 dB off, since the error counted as white", after="within 0.3 dB")
def test_spectrum_of_a_modulator(
    gains: tuple[float, ...], feedback: tuple[float, ...], dither: float, level: float
) -> None:
    """The powers that a program of its own has in bands from 0.1 % of the rate to half of it."""
    values, edges = 1 << 17, RATE * np.array([0.001, 0.01, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5])
    entry = level + dither * np.random.default_rng(5).normal(size=values)
    bits, x = np.empty(values), [0.0] * len(gains)
    for n, u in enumerate(entry.tolist()):
        v = 1.0 if x[-1] >= 0.0 else -1.0
        bits[n] = v
        before = [u, *x[:-1]]
        x = [now + g * (entry - f * v) for now, g, f, entry in zip(x, gains, feedback, before, strict=True)]
    f, density = scipy.signal.welch(bits, RATE, nperseg=1 << 11)
    budget = noise(modulator(gains, feedback, dither, level), "modulator.output", frequencies=f[1:-1].tolist())
    for low, high in itertools.pairwise(edges):
        inside = (f[1:-1] >= low) & (f[1:-1] < high)
        ratio = np.sum(budget.density[inside]) / np.sum(density[1:-1][inside])
        assert 10.0 * math.log10(ratio) == pytest.approx(0.0, abs=0.3), (low, high)
    assert budget.rms == pytest.approx(math.sqrt(1.0 - level**2), rel=0.01)  # since each bit is 1 or -1
    assert "has the spectrum of these runs" in budget.notes[-1]


@pytest.mark.exhaustive
def test_error_that_repeats_itself_is_told() -> None:
    budget = noise(modulator((1.0,), (1.0,), 1e-30, 0.1), "modulator.output")
    assert "is the same in both" in budget.notes[-1]
    assert "is not white" in budget.notes[-1]
    steady = noise(modulator((1.0,), (1.0,), 0.4, 0.1), "modulator.output")
    assert "has the spectrum" in steady.notes[-1]


@pytest.mark.exhaustive
def test_machine_code_sees_what_plain_python_sees() -> None:
    graph = modulator((1.0, 1.0), (1.0, 2.0), 0.05, 0.01)
    planned = plan(graph)
    names, seed, count = set(planned.blocks), graph.seed, 200
    watched = Watched(planned, start(planned), names, {"modulator"}, seed).taken(count, SETTLING)
    runs = compiled_runs(planned, 0, names, {"modulator": "output"}, (seed,), 0, {})
    assert runs is not None
    # In plain Python one tick more is run at first. Levels are 0 and 1, and a value of 0 is halfway.
    seen = runs[0]["modulator"].rows[1 : count + 1]
    assert seen[:, 0] == pytest.approx(watched["modulator"][0].rows[:, 0], abs=1e-12)
    assert (seen[:, 1] == watched["modulator"][0].rows[:, 1]).all()


@pytest.mark.parametrize("level", [-0.4, 0.4])
@pytest.mark.defect("S29", before="in the upper half of its range a modulator had no slope", after="has that of a gain")
def test_slope_of_a_modulator_on_both_sides_of_the_middle(level: float) -> None:
    graph = modulator((0.2,), (1.0,), 0.0, level)
    poles = linearise(graph, ["level.output"], ["modulator.output"], at="10 us").poles()
    assert float(poles[0].real) == pytest.approx(0.8)
