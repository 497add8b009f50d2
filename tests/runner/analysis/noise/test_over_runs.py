"""Deviations of single values over runs, against closed forms, brute force and runs."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proofmass import Graph, ModelError, Study, deviation_over_runs, run_study
from proofmass.blocks import (
    AnalogToDigital,
    Decimator,
    DiscreteIntegrator,
    NumericallyControlledOscillator,
    Product,
    Sine,
    Sum,
    WhiteNoise,
)
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.measures import Measure
from proofmass.runner.analysis.noise.over_runs import densities
from proofmass.runner.analysis.spectrum.windows import window
from proofmass.runner.planning.plan import plan

RATE = 1000.0


def walk() -> Graph:
    """White noise of 2 V^2/Hz one-sided, 1000 V^2 a value, and its integral."""
    blocks = {"white": WhiteNoise(density=math.sqrt(2.0), unit="V"), "sum": DiscreteIntegrator(input_unit="V")}
    return Graph(name="", rate="1 kHz", samples=500, blocks=blocks, wires=["white.output -> sum.input"])


def mixed() -> Graph:
    """White noise times a carrier that fits no period of the schedule, its integral and its means over ten values."""
    blocks = {
        "white": WhiteNoise(density=math.sqrt(2.0), unit="V"),
        "carrier": NumericallyControlledOscillator(frequency=123.4567),
        "mixer": Product(first_unit="V"),
        "sum": DiscreteIntegrator(input_unit="V"),
        "mean": Decimator(ratio=10, unit="V"),
    }
    wires = [
        "white.output -> mixer.first", "carrier.sine -> mixer.second", "mixer.output -> sum.input",
        "mixer.output -> mean.input",
    ]  # fmt: skip
    return Graph(name="", rate="1 kHz", samples=501, blocks=blocks, wires=wires)


LATE = """
name = "a slow reader, and a late one"
rate = "1 kHz"
samples = 3000
wires = ["white.output -> sum.input", "sum.output -> slow.input", "sum.output -> late.input"]
[blocks]
white = { kind = "WhiteNoise", density = "1.4142135623730951 V/sqrt(Hz)", unit = "V" }
sum = { kind = "DiscreteIntegrator", input_unit = "V" }
slow = { kind = "Gain", rate = "1 Hz", input_unit = "s", output_unit = "s" }
late = { kind = "Gain", clock_offset = "0.4 ms", input_unit = "s", output_unit = "s" }
"""


def sines(count: int) -> np.ndarray:
    return np.sin(2.0 * np.pi * 123.4567 * np.arange(count) / RATE)


@pytest.mark.parametrize("ticks", [2, 9, 100, 500])
def test_a_random_walk(ticks: int) -> None:
    """The integral in tick n has taken the values before it: n times 1000 V^2 times the period squared."""
    last = deviation_over_runs(walk(), "sum.output", until=ticks / RATE)
    assert last.deviation == pytest.approx(math.sqrt(ticks * 1000.0) / RATE, rel=1e-12)
    assert last.time == pytest.approx(ticks / RATE)
    assert last.sources == {"white": last.deviation}


def test_a_carrier_that_fits_no_period() -> None:
    last = deviation_over_runs(mixed(), "sum.output")
    assert last.deviation**2 == pytest.approx(1000.0 * float(np.sum(sines(500) ** 2)) / RATE**2, rel=1e-9)
    now = deviation_over_runs(mixed(), "mixer.output")
    assert now.deviation**2 == pytest.approx(1000.0 * sines(501)[-1] ** 2, rel=1e-9)


def test_lines_of_the_last_values() -> None:
    """Of the integral and of the means of modulated noise: sums over the random numbers, one by one."""
    count, length = 501, 32
    for output, rows in (("sum.output", _integral(count)), ("mean.mean", _means(count))):
        weights = window("hann", length)
        ((_, lines, density),) = densities(plan(mixed()), [output], count, weights)
        transform = np.fft.rfft(weights[:, None] * rows[-length:] * sines(count), axis=0)
        rate = 2.0 * lines[-1]
        expected = 1000.0 * np.sum(np.abs(transform) ** 2, axis=1) * 2.0 / (rate * np.sum(weights**2))
        assert density == pytest.approx(expected, rel=1e-8)


def _integral(count: int) -> np.ndarray:
    """Weights of the random numbers in each value of the integral."""
    return np.tril(np.ones((count, count)), -1) / RATE


def _means(count: int) -> np.ndarray:
    """Those in the means, each of the ten values up to the tick before."""
    rows = np.zeros((-(-count // 10), count))
    for k in range(1, len(rows)):
        rows[k, 10 * k - 10 : 10 * k] = 0.1
    return rows


def test_a_rounding_is_uniform_over_a_step() -> None:
    blocks = {
        "white": WhiteNoise(density=1e-3, unit="V"),
        "adc": AnalogToDigital(bits=8, reference=1.0),
    }
    graph = Graph(name="", rate="1 kHz", samples=10, blocks=blocks, wires=["white.output -> adc.voltage"])
    last = deviation_over_runs(graph, "adc.number")
    assert last.sources["adc"] == pytest.approx(math.sqrt(1.0 / 12.0), rel=1e-12)
    assert last.deviation == pytest.approx(math.hypot(*last.sources.values()), rel=1e-12)


@pytest.mark.defect("S829", before="0.29 steps of the second converter", after="none: all runs are alike there")
def test_a_rounding_that_no_random_number_reaches_is_alike_in_all_runs() -> None:
    blocks = {
        "white": WhiteNoise(density=1e-3, unit="V"),
        "tone": Sine(frequency=33.0, unit="V"),
        "first": AnalogToDigital(bits=8, reference=1.0),
        "second": AnalogToDigital(bits=8, reference=1.0),
        "sum": Sum(),
    }
    wires = ["white.output -> first.voltage", "tone.output -> second.voltage", "first.number -> sum.first"]
    graph = Graph(name="", rate="1 kHz", samples=10, blocks=blocks, wires=[*wires, "second.number -> sum.second"])
    assert set(deviation_over_runs(graph, "sum.output").sources) == {"white", "first"}
    assert deviation_over_runs(graph, "second.number").deviation == 0.0


def test_many_runs() -> None:
    last = deviation_over_runs(mixed(), "sum.output")
    measured = replace(mixed(), measures={"end": Measure("sum.output", "last")})
    values = run_study(Study(measured, runs=2000)).values["end"]
    assert np.std(values) == pytest.approx(last.deviation, rel=4.0 / math.sqrt(4000.0))


def test_a_time_before_the_first_value() -> None:
    with pytest.raises(ModelError, match="no value before that time"):
        deviation_over_runs(read_graph_text(LATE), "late.output", until=0.0)
    assert deviation_over_runs(read_graph_text(LATE), "late.output", until=0.0004).time == 0.0004


@pytest.mark.defect("S604", before="the value of 0 s, at 0.999 s", after="the value of the last tick up to that time")
@pytest.mark.exhaustive("0.0-0.0", "1.7-1.0")
@pytest.mark.parametrize(("until", "at"), [(0.0, 0.0), (0.999, 0.0), (1.0, 1.0), (1.7, 1.0), (2.0, 2.0)])
def test_a_slow_output_has_the_value_of_its_last_tick(until: float, at: float) -> None:
    slow = deviation_over_runs(read_graph_text(LATE), "slow.output", until=until)
    assert slow.time == at
    assert slow.deviation == pytest.approx(math.sqrt(at * RATE * 1000.0) / RATE, rel=1e-12)
