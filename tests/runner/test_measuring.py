"""Measures of a run against NumPy on its traces, in both engines, for numbers, codes and bits at several rates."""

import dataclasses
import math

import numpy as np
import pytest

from proofmass.graphs.measures import STATISTICS
from proofmass.graphs.toml_reader import read_graph_text
from proofmass.runner.engine.simulate import EngineName, simulate

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


SIGNALS = {"number": "sum.output", "code": "adc.code", "bit": "bits.bit"}
MEASURED = dataclasses.replace(
    GRAPH,
    measures={
        f"{kind}_{statistic}": {"signal": signal, "statistic": statistic, "from": BEGIN}
        for kind, signal in SIGNALS.items()
        for statistic in STATISTICS
    },
)


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
            "min": y.min(),
            "max": y.max(),
            "peak_to_peak": np.ptp(y),
            "last": y[-1],
            "slope": np.polyfit(t - t.mean(), y, 1)[0],
        }
        found = {statistic: result.measures[f"{kind}_{statistic}"].value for statistic in STATISTICS}
        assert found == pytest.approx(expected, rel=1e-11)


def test_units_and_attributes() -> None:
    result = simulate(MEASURED, engine="python")
    units = {name: measure.unit for name, measure in result.measures.items()}
    assert (units["number_mean"], units["number_slope"]) == ("V", "(V)/s")
    assert (units["code_mean"], units["code_slope"]) == ("1", "1/s")
    value = result.measures["number_max"].value
    assert result.to_xarray().attrs["measure_number_max"] == f"{value!r} V"


def test_engines_traces_and_other_measures_change_no_bit() -> None:
    python = simulate(MEASURED, engine="python").measures
    assert simulate(MEASURED, engine="compiled").measures == python
    alone = dataclasses.replace(MEASURED, probes=(), measures={"number_mean": MEASURED.measures["number_mean"]})
    assert simulate(alone, engine="compiled").measures["number_mean"] == python["number_mean"]
    plain, measured = simulate(GRAPH, engine="python"), simulate(MEASURED, engine="compiled")
    for name in plain:
        assert (plain[name].values == measured[name].values).all()


def test_a_measure_that_begins_after_the_run_is_not_a_number() -> None:
    result = simulate(MEASURED, duration=0.1)
    assert all(math.isnan(measure.value) for measure in result.measures.values())
    assert result.measures["bit_last"].as_data()["value"] is None
