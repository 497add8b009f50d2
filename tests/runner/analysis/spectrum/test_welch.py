"""Densities against scipy.signal, and against what is known of the signal."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy.signal

from proofmass import Graph, Series, allan, simulate, spectrum
from proofmass.blocks import Gain, WhiteNoise
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.spectrum.windows import WINDOWS, window

SCIPY = {"rectangular": "boxcar", "blackman-harris": "blackmanharris", "flat-top": "flattop"}
NOISE = np.random.default_rng(7).normal(size=3001) + 5.0


@pytest.mark.parametrize("name", sorted(WINDOWS.keys() - {"blackman-harris-7"}))
@pytest.mark.parametrize("length", [64, 65])
def test_windows_are_those_of_scipy(name: str, length: int) -> None:
    assert window(name, length) == pytest.approx(scipy.signal.get_window(SCIPY.get(name, name), length), abs=1e-15)


@pytest.mark.exhaustive(but=9)
@pytest.mark.parametrize("name", sorted(WINDOWS))
@pytest.mark.parametrize("segment", [256, 255, 254, 3001])
def test_densities_are_those_of_scipy(name: str, segment: int) -> None:
    found = spectrum(NOISE, rate=250.0, window=name, segment=segment)
    frequencies, density = scipy.signal.welch(NOISE, 250.0, window=window(name, segment), nperseg=segment)
    assert found.frequencies == pytest.approx(frequencies, rel=1e-12)
    assert found.density[1:] == pytest.approx(density[1:], rel=1e-11)
    assert found.segments == 1 + (3001 - segment) // (segment - segment // 2)


def test_power_is_the_spectrum_of_scipy() -> None:
    found = spectrum(NOISE, rate=250.0, window="flat-top", segment=300)
    _, power = scipy.signal.welch(NOISE, 250.0, window=window("flat-top", 300), nperseg=300, scaling="spectrum")
    assert found.power[1:] == pytest.approx(power[1:], rel=1e-12)


def test_the_density_of_white_noise() -> None:
    blocks = {"w": WhiteNoise(density=0.3, unit="V"), "o": Gain(input_unit="V", output_unit="V")}
    graph = Graph(
        name="", rate="10 kHz", blocks=blocks, wires=["w.output -> o.input"], probes=["o.output"], samples=200_000
    )
    found = spectrum(simulate(graph)["o.output"], segment=512)
    assert (found.name, found.unit, found.density_unit, found.rate) == ("o.output", "V", "V/sqrt(Hz)", 10e3)
    assert np.mean(found.density[2:-2]) == pytest.approx(0.09, rel=0.02)
    assert found.rms() == pytest.approx(0.3 * math.sqrt(5000.0), rel=0.01)
    assert found.rms((1000.0, 2000.0)) == pytest.approx(0.3 * math.sqrt(1000.0), rel=0.03)
    assert abs(found.slope((100.0, 4000.0))) < 0.5


def test_the_scatter_of_a_line_is_that_of_its_degrees_of_freedom() -> None:
    random = np.random.default_rng(3)
    found = [spectrum(random.normal(size=1024), rate=1.0, segment=128) for _ in range(400)]
    lines = np.array([one.density[2:-2] for one in found])
    measured = 2.0 * np.mean(lines) ** 2 / np.mean(np.var(lines, axis=0))
    assert found[0].freedom == pytest.approx(measured, rel=0.03)


def test_the_mean_square_of_a_tone_is_in_its_line() -> None:
    values = 3.0 * np.sin(2.0 * np.pi * 100.0 * np.arange(1000) / 1000.0)
    for name in WINDOWS:
        found = spectrum(values, rate=1000.0, window=name, segment=0)
        assert found.power[100] == pytest.approx(4.5, rel=1e-12)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ModelError, match=r"there is no such window[\s\S]*did you mean hann"):
        spectrum(NOISE, rate=1.0, window="han")
    with pytest.raises(ModelError, match="a segment of this length does not fit"):
        spectrum(NOISE, rate=1.0, segment=3002)
    with pytest.raises(ModelError, match="too short for a spectrum"):
        spectrum(NOISE[:15], rate=1.0)
    with pytest.raises(ModelError, match="fewer than two lines"):
        spectrum(NOISE, rate=1.0).slope((0.2, 0.2001))
    with pytest.raises(ValueError, match="need a rate"):
        spectrum(NOISE)


def test_a_series_without_its_start() -> None:
    series = Series(np.arange(10.0), 0.5)
    assert list(series.behind(2.0).values) == [4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    assert list(series.behind(1.9).values) == [4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    with pytest.raises(ModelError, match="nothing is left"):
        series.behind(5.0)


ROW = np.random.default_rng(1).normal(size=400)


@pytest.mark.defect("S1045", before="columns in a row, masked and imaginary parts as numbers", after="refused")
@pytest.mark.parametrize("analysis", [spectrum, allan])
@pytest.mark.parametrize(
    ("values", "said"),
    [
        (ROW.reshape(200, 2), r"row of real numbers[\s\S]*shape \(200, 2\)[\s\S]*values\[:, 0\]"),
        (ROW + 1j, r"row of real numbers[\s\S]*complex128"),
        (set(ROW), "row of real numbers"),
        (np.ma.masked_greater(ROW, 1.0), "all values must be finite"),
    ],
)
def test_what_is_no_row_of_numbers_is_refused(analysis: Callable[..., object], values: object, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        analysis(values, rate=100.0)


@pytest.mark.defect("S1046", before="a density of NaN; allan: it does not move, or a ValueError", after="refused")
@pytest.mark.parametrize("analysis", [spectrum, allan])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_signal_that_is_not_finite_is_refused(analysis: Callable[..., object], value: float) -> None:
    values = ROW.copy()
    values[[7, 9]] = value
    with pytest.raises(ModelError, match=rf"must be finite[\s\S]*{value} in row 7, and 1 more"):
        analysis(values, rate=100.0)


def test_one_column_is_a_row() -> None:
    assert np.array_equal(spectrum(ROW[:, None], rate=100.0).density, spectrum(list(ROW), rate=100.0).density)
