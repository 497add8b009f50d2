"""Noise along a run whose orbit does not come back, against sums over the random numbers and against runs."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proofmass import Graph, ModelError, noise, read_graph, simulate
from proofmass.blocks import (
    Difference,
    DiscreteIntegrator,
    Gain,
    NumericallyControlledOscillator,
    Product,
    Step,
    Sum,
    WhiteNoise,
)
from proofmass.runner.analysis.noise.along_run import _lines

RATE, FREQUENCY, GAIN, COUNT, RUNS = 1000.0, 7.3890561, 40.0, 501, 250
LENGTH = COUNT // 4 * 2  # values in the window


def lock_in() -> Graph:
    """Noise times a carrier that fits no number of ticks, less what the carrier says of their mean so far."""
    blocks = {
        "white": WhiteNoise(density=math.sqrt(2.0), unit="V"),
        "carrier": NumericallyControlledOscillator(frequency=FREQUENCY),
        "missing": Difference(unit="V"),
        "error": Product(first_unit="V"),
        "sum": DiscreteIntegrator(input_unit="V"),
        "amplitude": Gain(gain=GAIN, input_unit="s", output_unit="V"),
        "again": Product(first_unit="V"),
        "idle": Gain(),
        "silent": WhiteNoise(unit="V"),
        "nothing": Gain(gain=0.0, input_unit="V", output_unit="V"),
        "all": Sum(unit="V"),
    }
    wires = [
        "white.output -> all.first", "silent.output -> nothing.input", "nothing.output -> all.second",
        "all.output -> missing.first", "again.output -> missing.second", "missing.output -> error.first",
        "carrier.sine -> error.second", "error.output -> sum.input", "sum.output -> amplitude.input",
        "amplitude.output -> again.first", "carrier.sine -> again.second", "carrier.sine -> idle.input",
    ]  # fmt: skip
    return Graph(name="", rate="1 kHz", samples=COUNT, blocks=blocks, wires=wires, probes=["amplitude.output"])


def hann() -> np.ndarray:
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(LENGTH) / LENGTH)


def weights_of_random_numbers() -> np.ndarray:
    """Row n: a[n] by each number w, of a' = a + gain / rate * c (w - c a), times the deviation of w."""
    carrier, rows, now = np.sin(2.0 * np.pi * FREQUENCY * np.arange(COUNT) / RATE), [], np.zeros(COUNT)
    for n in range(COUNT):
        rows.append(now)
        now = now * (1.0 - GAIN / RATE * carrier[n] ** 2)
        now[n] += GAIN / RATE * carrier[n]
    return np.array(rows)[-LENGTH:] * math.sqrt(RATE)


def test_against_sums_over_the_random_numbers() -> None:
    budget, rows, window = noise(lock_in(), "amplitude.output"), weights_of_random_numbers(), hann()
    weight = float(np.sum(window**2))
    assert budget.rms**2 == pytest.approx(float(window**2 @ np.sum(rows**2, axis=1)) / weight, rel=1e-7)
    turns = np.exp(-2j * np.pi * np.outer(budget.frequencies, np.arange(LENGTH)) / RATE)
    expected = 2.0 / (RATE * weight) * np.sum(np.abs((turns * window) @ rows) ** 2, axis=1)
    assert budget.density == pytest.approx(expected, rel=1e-6)
    assert any("the orbit does not come back: noise is that along the run" in note for note in budget.notes)
    (source,) = budget.sources
    assert (source.block, source.kind, source.share) == ("white", "WhiteNoise", 1.0)


@pytest.mark.exhaustive
def test_a_band_and_frequencies() -> None:
    """All bands together have the whole mean square, but for the lines at rest and at half the rate, which count
    twice."""
    whole = noise(lock_in(), "amplitude.output")
    bands = [noise(lock_in(), "amplitude.output", band=band) for band in ((0.0, 20.0), (20.0, 500.0))]
    at_rest = bands[0].density[0] * 0.5 * RATE / LENGTH
    assert sum(band.rms**2 for band in bands) - at_rest == pytest.approx(whole.rms**2, rel=1e-3)
    lines = noise(lock_in(), "amplitude.output", frequencies=(8.0, 100.0))
    assert lines.frequencies.tolist() == [8.0, 100.0]
    inside = bands[0].frequencies.tolist().index(8.0)
    assert lines.density[0] == pytest.approx(bands[0].density[inside])


@pytest.mark.exhaustive
def test_against_runs() -> None:
    window = hann()
    values = np.array(
        [simulate(lock_in(), seed=seed)["amplitude.output"].values[-LENGTH:] for seed in range(1, RUNS + 1)]
    )
    _within_three_errors(values, window, noise(lock_in(), "amplitude.output").rms)
    band = noise(lock_in(), "amplitude.output", band=(5.0, 25.0))
    lines = np.fft.rfftfreq(LENGTH, 1.0 / RATE)
    inside = (lines >= 5.0) & (lines < 25.0)
    powers = np.sum(np.abs(np.fft.rfft(values * window, axis=1))[:, inside] ** 2, axis=1)
    squares = powers * 2.0 / (LENGTH * float(np.sum(window**2)))
    assert abs(np.mean(squares) - band.rms**2) < 3.0 * np.std(squares) / math.sqrt(RUNS)


@pytest.mark.exhaustive
def test_what_has_no_noise_and_what_is_too_short() -> None:
    with pytest.raises(ModelError, match=r"no noise reaches idle\.output"):
        noise(lock_in(), "idle.output")
    with pytest.raises(ModelError, match="the run is too short for its noise"):
        noise(replace(lock_in(), samples=9), "amplitude.output")
    with pytest.raises(ModelError, match="does not repeat"):
        noise(lock_in(), "amplitude.output", at="1 s")


@pytest.mark.exhaustive
def test_a_gyroscope_against_runs() -> None:
    graph = read_graph("library:fibre_optic_gyroscope")
    count = 12001 // 4 * 2
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
    values = np.array([simulate(graph, seed=seed)["trim.output"].values[-count:] for seed in range(1, 201)])
    _within_three_errors(values - np.mean(values, axis=0), window, noise(graph, "trim.output").rms, 199)


def _within_three_errors(values: np.ndarray, window: np.ndarray, rms: float, freedom: int = RUNS) -> None:
    squares = values**2 @ window**2 / float(np.sum(window**2)) * len(values) / freedom
    assert abs(np.mean(squares) - rms**2) < 3.0 * np.std(squares) / math.sqrt(len(values))


@pytest.mark.parametrize("count", [100, 102])
def test_lines_of_a_band_are_those_of_the_transform(count: int) -> None:
    whole = np.fft.rfftfreq(count, 1.0 / RATE)
    assert _lines(RATE, count, (0.0, RATE), ()) == pytest.approx(whole)
    assert _lines(RATE, count, (whole[3], whole[7]), ()) == pytest.approx(whole[3:7])
    assert _lines(RATE, count, None, (3.0, 70.0)).tolist() == [3.0, 70.0]
    spread = _lines(RATE, count, None, ())
    assert (spread[0], spread[-1]) == pytest.approx((2.0 * RATE / count, RATE / 2.0))
    assert np.ptp(np.diff(np.log(spread))) < 1e-9


@pytest.mark.defect(
    "S1036", before="a mean with a window that ends there: 7e-12 for 6e-6", after="refused, with --until"
)
def test_noise_that_begins_at_the_end_of_the_run_has_no_budget() -> None:
    graph = lock_in()
    wires = [*map(str, graph.wires), "amplitude.output -> gated.first", "late.output -> gated.second"]
    late = {"late": Step(start_time=0.48), "gated": Product(first_unit="V")}
    gated = Graph(name="", rate="1 kHz", samples=COUNT, blocks={**graph.blocks, **late}, wires=wires)
    with pytest.raises(ModelError, match="begins in the last quarter") as caught:
        noise(gated, "gated.output")
    assert caught.value.problems[0].hint == '--until "501 ms" tells that of the value there'
