"""Measures of a run against NumPy on its traces, in both engines, for numbers, codes and bits at several rates."""

import dataclasses
import math

import numpy as np
import numpy.typing as npt
import pytest
import scipy.signal

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.statistics import STATISTICS
from proofmass.graphs.studies.build import Study
from proofmass.runner.plan.measuring import refuse_late
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.whole.study import run_study

GRAPH = read_graph_text("""
name = "numbers, codes and bits"
rate = "2 kHz"
duration = "0.4 s"
seed = 3
wires = ["noise.output -> sum.first", "ramp.output -> sum.second", "sum.output -> adc.voltage"]
probes = ["sum.output", "adc.code", "bits.bit"]
blocks.noise = { kind = "WhiteNoise", density = "1 mV/sqrt(Hz)", unit = "V" }
blocks.ramp = { kind = "Ramp", slope = "0.4 V/s", offset = "1 V", unit = "V" }
blocks.sum = { kind = "Sum", unit = "V" }
blocks.adc = { kind = "AnalogToDigital", bits = 12, rate = "500 Hz" }
blocks.bits = { kind = "ShiftRegister", rate = "250 Hz" }
""")
BEGIN = 0.1234
Array = npt.NDArray[np.float64]


OPTIONS = {
    "percentile": {"percent": "75 %"},
    "allan_deviation": {"tau": "20 ms"},
    "settling_time": {"target": 1.0, "within": 0.12},
    "tone_amplitude": {"frequency": "37 Hz"},
    "tone_phase": {"frequency": "37 Hz"},
    "band_rms": {"low": "20 Hz", "high": "80 Hz"},
    "density": {"frequency": "100 Hz", "segment": "80 ms"},
}
SIGNALS = {"number": "sum.output", "code": "adc.code", "bit": "bits.bit"}
MEASURED = dataclasses.replace(
    GRAPH,
    measures={
        f"{kind}_{statistic}": {"signal": signal, "statistic": statistic, "from": BEGIN, **OPTIONS.get(statistic, {})}
        for kind, signal in SIGNALS.items()
        for statistic in STATISTICS
    },
)


@pytest.mark.exhaustive("compiled")
@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_against_numpy(engine: EngineName) -> None:
    result = simulate(MEASURED, engine=engine)
    for kind, signal in SIGNALS.items():
        trace = result[signal]
        counted = trace.times >= BEGIN
        t, y = trace.times[counted], trace.values[counted].astype(float)
        expected = {
            "mean": y.mean(),
            "std": y.std(ddof=1),
            "rms": math.sqrt((y**2).mean()),
            "mean_absolute": np.abs(y).mean(),
            "min": y.min(),
            "max": y.max(),
            "peak_to_peak": np.ptp(y),
            "percentile": np.percentile(y, 75),
            "last": y[-1],
            "slope": np.polyfit(t - t.mean(), y, 1)[0],
            "allan_deviation": allan(y, round(0.02 / (t[1] - t[0]))),
            "settling_time": settling(t, y) - BEGIN,
            "tone_amplitude": math.hypot(*tone(t, y)),
            "tone_phase": math.atan2(*tone(t, y)[::-1]),
            "band_rms": band_rms(trace.values.astype(float), counted, t[1] - t[0]),
            "density": welch(y, t[1] - t[0]),
        }
        found = {statistic: result.measures[f"{kind}_{statistic}"].value for statistic in STATISTICS}
        assert found == pytest.approx(expected, rel=1e-11, nan_ok=True)


def settling(t: Array, y: Array) -> float:
    outside = np.flatnonzero(abs(y - 1.0) > 0.12)
    after = 1 + outside[-1] if outside.size else 0
    return float(t[after]) if after < len(t) else math.nan


def allan(y: "np.ndarray[tuple[int], np.dtype[np.float64]]", m: int) -> float:
    means = np.convolve(y, np.ones(m) / m, "valid")
    return math.sqrt(0.5 * ((means[m:] - means[:-m]) ** 2).mean())


def tone(t: Array, y: Array) -> tuple[float, float]:
    turn = 2.0 * np.pi * 37.0 * t
    sine, cosine, _ = np.linalg.lstsq(np.column_stack([np.sin(turn), np.cos(turn), np.ones_like(t)]), y)[0]
    return float(sine), float(cosine)


def band_rms(y: Array, counted: "np.ndarray[tuple[int], np.dtype[np.bool_]]", period: float) -> float:
    y = y - y[0]  # filters begin as if the first value had been there for ever
    for corner, kind in ((20.0, "highpass"), (80.0, "lowpass")):
        y = scipy.signal.sosfilt(scipy.signal.butter(4, corner, kind, output="sos", fs=1.0 / period), y)
    return math.sqrt(float(np.mean(y[counted] ** 2)))


def welch(y: Array, period: float) -> float:
    count = round(0.08 / period)
    f, density = scipy.signal.welch(y, 1.0 / period, "hann", nperseg=count, noverlap=count // 2, detrend="constant")
    return math.sqrt(float(density[int(np.argmin(np.abs(f - 100.0)))]))


def test_measures_with_other_options_are_other_measures() -> None:
    measures = {
        f"p{percent}": {"signal": "sum.output", "statistic": "percentile", "percent": percent}
        for percent in (10, 50, 90)
    }
    found = simulate(dataclasses.replace(GRAPH, measures=measures), engine="compiled").measures
    assert found["p10"].value < found["p50"].value - 0.05 < found["p90"].value - 0.1


@pytest.mark.exhaustive
def test_percentiles_of_many_values_have_the_bits_of_plain_python() -> None:
    """Beyond the 1,024 values that are kept; in threads and in lanes too."""
    measures = {
        f"p{round(percent)}": {"signal": "sum.output", "statistic": "percentile", "percent": percent}
        for percent in (10, 99.9)
    }
    graph = dataclasses.replace(GRAPH, duration=1.5, measures=measures)
    study = Study(graph, runs=9)
    expected = run_study(study, threads=1, lanes=0).digest
    assert [run_study(study, threads=2, lanes=lanes).digest for lanes in (2, 4, 8)] == [expected] * 3
    found = [simulate(graph, engine=engine).measures for engine in ("python", "compiled")]
    assert found[0] == found[1]


def test_a_measure_begins_within_the_run() -> None:
    """The tick at 0.1 s is number 200, which a run of 201 ticks has."""
    late = plan(
        dataclasses.replace(GRAPH, measures={"mean": {"signal": "sum.output", "statistic": "mean", "from": 0.1}})
    )
    refuse_late(late, 201)
    with pytest.raises(ModelError, match=r"(?s)measures\.mean\.from.*a run of 200 ticks.*more than 200 ticks"):
        refuse_late(late, 200)


def test_an_averaging_time_beyond_the_run_or_the_memory_is_refused() -> None:
    long = dataclasses.replace(
        GRAPH, measures={"allan": {"signal": "sum.output", "statistic": "allan_deviation", "tau": 1}}
    )
    assert math.isnan(simulate(long, engine="python").measures["allan"].value)
    with pytest.raises(ModelError, match=r"(?s)measures\.allan\.from.*a run of 801 ticks"):
        refuse_late(plan(long), 801)
    longer = dataclasses.replace(
        GRAPH, measures={"allan": {"signal": "sum.output", "statistic": "allan_deviation", "tau": "1 d"}}
    )
    with pytest.raises(ModelError, match=r"measures\.allan\.tau"):
        plan(longer)


def test_units_and_attributes() -> None:
    result = simulate(MEASURED, engine="python")
    units = {name: measure.unit for name, measure in result.measures.items()}
    assert (units["number_mean"], units["number_slope"]) == ("V", "V/s")
    assert (units["code_mean"], units["code_slope"]) == ("1", "1/s")
    assert (units["number_allan_deviation"], units["number_settling_time"]) == ("V", "s")
    value = result.measures["number_max"].value
    assert result.to_xarray().attrs["measure_number_max"] == f"{value!r} V"


@pytest.mark.exhaustive
def test_engines_traces_and_other_measures_change_no_bit() -> None:
    python = simulate(MEASURED, engine="python").measures
    assert simulate(MEASURED, engine="compiled").measures == python
    alone = dataclasses.replace(MEASURED, probes=(), measures={"number_mean": MEASURED.measures["number_mean"]})
    assert simulate(alone, engine="compiled").measures["number_mean"] == python["number_mean"]
    plain, measured = simulate(GRAPH, engine="python"), simulate(MEASURED, engine="compiled")
    for name in plain:
        assert (plain[name].values == measured[name].values).all()


@pytest.mark.exhaustive
def test_lanes_and_plain_python_measure_the_same_bits() -> None:
    measures = {name: measure for name, measure in MEASURED.measures.items() if name.startswith("number_")}
    graph = dataclasses.replace(MEASURED, measures=measures)
    study = Study(graph, runs=5, seed=2, spread={"ramp.slope": {"uniform": 0.2, "relative": True}})
    python = run_study(study, engine="python")
    assert python.values.keys() == measures.keys()
    assert run_study(study, engine="compiled", lanes=4).digest == python.digest


def test_a_measure_that_begins_after_the_run_is_not_a_number() -> None:
    result = simulate(MEASURED, duration=0.1)
    assert all(math.isnan(measure.value) for measure in result.measures.values())
    assert result.measures["bit_last"].as_data()["value"] is None


@pytest.mark.defect("S875", before="0 for a tone at half the rate, and bands and densities beyond it", after="refused")
def test_frequencies_that_a_signal_does_not_have_are_refused_together() -> None:
    """The codes come at 500 Hz, the sums at 2 kHz. At half the rate a density is defined, and a tone is not."""
    measures = {
        "tone": {"signal": "adc.code", "statistic": "tone_amplitude", "frequency": "250 Hz"},
        "phase": {"signal": "adc.code", "statistic": "tone_phase", "frequency": "250 Hz"},
        "band": {"signal": "sum.output", "statistic": "band_rms", "low": "10 Hz", "high": "1001 Hz"},
        "density": {"signal": "adc.code", "statistic": "density", "frequency": "300 Hz", "segment": "80 ms"},
        "edge": {"signal": "adc.code", "statistic": "density", "frequency": "250 Hz", "segment": "80 ms"},
        "whole": {"signal": "sum.output", "statistic": "band_rms", "low": "10 Hz", "high": "1 kHz"},
    }
    with pytest.raises(ModelError) as caught:
        plan(dataclasses.replace(GRAPH, measures=measures))
    said = sorted((problem.key, problem.got) for problem in caught.value.problems)
    assert said == [
        ("measures.band.high", "1.001 kHz, of sum.output at 2 kHz"),
        ("measures.density.frequency", "300 Hz, of adc.code at 500 Hz"),
        ("measures.phase.frequency", "250 Hz, of adc.code at 500 Hz"),
        ("measures.tone.frequency", "250 Hz, of adc.code at 500 Hz"),
    ]
