"""Measures of signals with clock offsets against NumPy on the times of their traces: all statistics, random windows."""

import math
import random
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import scipy.signal

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.statistics import STATISTICS
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import simulate
from tests.by_hand.amounts import amounts

PARTS = """
name = "late clocks"
rate = "10 kHz"
duration = "0.2 s"
seed = 5
wires = [
    "noise.output -> sum.first", "sine.output -> sum.second", "sum.output -> punctual.voltage",
    "sum.output -> late.voltage", "sum.output -> late_part.voltage",
]
probes = ["punctual.number", "late.number", "late_part.number"]
[blocks]
noise = { kind = "WhiteNoise", density = "2 mV/sqrt(Hz)", unit = "V" }
sine = { kind = "Sine", amplitude = "1 V", frequency = "100 Hz", phase = "0.4 rad", unit = "V" }
sum = { kind = "Sum", unit = "V" }
punctual = { kind = "AnalogToDigital", bits = 16, reference = "2 V", rate = "2.5 kHz" }
late = { kind = "AnalogToDigital", bits = 16, reference = "2 V", rate = "2.5 kHz", clock_offset = "300 us" }
late_part = { graph = "part.toml", clock_offset = "70 us" }
[measures]
"""
PART = """
name = "a converter"
rate = "1 kHz"
exports = { voltage = "adc.voltage", number = "adc.number" }
[blocks]
adc = { kind = "AnalogToDigital", bits = 16, reference = "2 V", clock_offset = "800 us" }
"""
SIGNALS = ("punctual.number", "late.number", "late_part.number")
OPTIONS = {
    "percentile": "percent = 75",
    "allan_deviation": 'tau = "4 ms"',
    "settling_time": "target = 0, within = 17000",
    "tone_amplitude": 'frequency = "100 Hz"',
    "tone_phase": 'frequency = "100 Hz"',
    "band_rms": 'low = "20 Hz", high = "200 Hz"',
    "density": 'frequency = "100 Hz", segment = "40 ms"',
}
Array = npt.NDArray[np.float64]


@pytest.mark.parametrize("count", amounts(16, 512))
@pytest.mark.parametrize("engine", ["python", "compiled"])
@pytest.mark.defect("S214", before="phase 0.5885 rad of a clock 0.3 ms late", after="0.4 rad")
def test_all_statistics_in_random_windows(tmp_path: Path, engine: EngineName, count: int) -> None:
    chance = random.Random(7)
    statistics = tuple(STATISTICS)
    windows = []
    for number in range(count):
        start, end = chance.randrange(0, 40_000, 10), chance.choice([None, chance.randrange(90_000, 200_000, 10)])
        windows.append((SIGNALS[number % 3], statistics[number // 3 % len(statistics)], start, end))
    result = simulate(_graph(tmp_path, *windows), engine=engine)
    for number, (signal, statistic, start, end) in enumerate(windows):
        trace = result[signal]
        t, y = trace.times, trace.values.astype(float)
        counts = (t > start * 1e-6 - 1e-9) & ((t < end * 1e-6 - 1e-9) if end else True)
        found, expected = result.measures[f"m{number}"].value, _reference(statistic, t, y, counts, start * 1e-6)
        if statistic == "percentile":
            assert found == pytest.approx(expected, abs=0.05 * np.ptp(y[counts])), "an estimate"
        else:
            assert found == pytest.approx(expected, rel=1e-9, abs=1e-12, nan_ok=True), (signal, statistic, start, end)


def _graph(folder: Path, *windows: tuple[str, str, int, int | None], amplitude: str = "1 V") -> Graph:
    (folder / "part.toml").write_text(PART)
    (folder / "graph.toml").write_text(
        PARTS.replace("1 V", amplitude) + "".join(map(_written, range(len(windows)), windows))
    )
    return read_graph(folder / "graph.toml")


def _written(number: int, window: tuple[str, str, int, int | None]) -> str:
    signal, statistic, start, end = window
    options = f", {OPTIONS[statistic]}" if statistic in OPTIONS else ""
    until = f', until = "{end} us"' if end else ""
    return f'm{number} = {{ signal = "{signal}", statistic = "{statistic}", from = "{start} us"{until}{options} }}\n'


def _reference(statistic: str, t: Array, whole: Array, counts: npt.NDArray[np.bool_], start: float) -> float:
    period, y = t[1] - t[0], whole[counts]
    t = t[counts]
    match statistic:
        case "mean":
            return float(y.mean())
        case "std":
            return float(y.std(ddof=1))
        case "rms":
            return math.sqrt(float((y**2).mean()))
        case "mean_absolute":
            return float(np.abs(y).mean())
        case "min":
            return float(y.min())
        case "max":
            return float(y.max())
        case "peak_to_peak":
            return float(np.ptp(y))
        case "last":
            return float(y[-1])
        case "slope":
            return float(np.polyfit(t - t.mean(), y, 1)[0])
        case "percentile":
            return float(np.percentile(y, 75))
        case "allan_deviation":
            m = round(4e-3 / period)
            means = np.convolve(y, np.ones(m) / m, "valid")
            return math.sqrt(0.5 * float(((means[m:] - means[:-m]) ** 2).mean()))
        case "settling_time":
            outside = np.flatnonzero(np.abs(y) > 17000)
            after = outside[-1] + 1 if outside.size else 0
            return float(t[after]) - start if after < len(t) else math.nan
        case "tone_amplitude":
            return abs(_tone(t, y))
        case "tone_phase":
            return float(np.angle(_tone(t, y)))
        case "band_rms":
            whole = whole - whole[0]  # filters begin as if the first value had been there for ever
            for corner, kind in ((20.0, "highpass"), (200.0, "lowpass")):
                filtering = scipy.signal.butter(4, corner, kind, output="sos", fs=1.0 / period)
                whole = np.asarray(scipy.signal.sosfilt(filtering, whole))
            return math.sqrt(float((whole[counts] ** 2).mean()))
        case "density":
            n = round(40e-3 / period)
            f, power = scipy.signal.welch(y, 1.0 / period, "hann", nperseg=n, noverlap=n // 2, detrend="constant")
            return math.sqrt(float(power[int(np.argmin(np.abs(f - 100.0)))]))
    raise AssertionError(statistic)


def _tone(t: Array, y: Array) -> complex:
    turn = 2.0 * np.pi * 100.0 * t
    sine, cosine, _ = np.linalg.lstsq(np.column_stack([np.sin(turn), np.cos(turn), np.ones_like(t)]), y)[0]
    return complex(sine, cosine)


@pytest.mark.defect("S215", before="the value at `until` itself", after="the one before")
def test_the_last_value_before_a_time(tmp_path: Path) -> None:
    window = ("late.number", "last", 0, 100_300)  # a tick of the late clock, which no longer counts
    trace = (result := simulate(_graph(tmp_path, window), engine="python"))["late.number"]
    assert result.measures["m0"].value == trace.values[np.flatnonzero(trace.times < 0.1003 - 1e-9)[-1]]


def test_a_window_that_ends_before_the_first_late_value_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"(?s)measures\.m0\.until: too short.*1 or more samples"):
        plan(_graph(tmp_path, ("late.number", "mean", 0, 200)))


@pytest.mark.parametrize("engine", ["python", "compiled"])
@pytest.mark.parametrize(
    ("statistic", "seconds"), [("settling_time", 0.182), ("std", 6e-4), ("slope", 6e-4), ("tone_amplitude", 1e-3)]
)
@pytest.mark.defect("S216", before="a settling time of what never settles", after="none")
def test_no_value_of_too_few(tmp_path: Path, engine: EngineName, statistic: str, seconds: float) -> None:
    graph = _graph(tmp_path, ("late.number", statistic, 0, None), amplitude="1.5 V")  # it ends outside of `within`
    assert math.isnan(simulate(graph, duration=seconds, engine=engine).measures["m0"].value)
