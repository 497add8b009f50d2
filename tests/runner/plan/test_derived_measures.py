"""Measures of measures: values and units by hand, in runs and studies, in both engines; mistakes are named."""

import math
from typing import Any

import pytest

from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.derived import measure_units
from proofmass.graphs.model.differences import differences
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.studies.build import Study
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.whole.study import replay, run_study

TEXT = """\
name = "scale factor of two positions"
rate = "1 kHz"
samples = 3
wires = ["up.output -> rising.input", "down.output -> falling.input"]

[measures]
high = { signal = "rising.output", statistic = "last" }
low = { signal = "falling.output", statistic = "last" }
scale_factor = "= (high - low) / 2 g0"
bias = "= (high + low) / 2"
decibels = "= 20 * log10(abs(high / low))"
twice = "= 2 * scale_factor"

[blocks]
up = { kind = "Constant", value = "1 g0", unit = "m/s^2" }
down = { kind = "Constant", value = "-1 g0", unit = "m/s^2" }
rising = { kind = "Gain", gain = "1 V/g0", input_unit = "m/s^2", output_unit = "mV" }
falling = { kind = "Gain", gain = "0.9 V/g0", input_unit = "m/s^2", output_unit = "mV" }
"""
GRAPH = read_graph_text(TEXT)
G0 = 9.80665


def test_values_and_units() -> None:
    """The signals are in millivolts; what follows from them is in coherent units."""
    measures = simulate(GRAPH, engine="python").measures
    assert measures["high"].value == pytest.approx(1000.0)
    found = {name: (measure.value, measure.unit) for name, measure in measures.items()}
    assert found["scale_factor"] == (pytest.approx(1.9 / (2 * G0)), "V/(m/s^2)")
    assert found["bias"] == (pytest.approx(0.05), "V")
    assert found["decibels"] == (pytest.approx(20 * math.log10(1 / 0.9)), "1")
    assert found["twice"][0] == pytest.approx(1.9 / G0)
    assert measure_units(flatten(GRAPH)) == {name: measure.unit for name, measure in measures.items()}


def test_in_studies_of_both_engines() -> None:
    tables: dict[str, Any] = {
        "spread": {"rising.gain": {"normal": "1 %", "relative": True}},
        "limits": {"bias": {"at_least": "50 mV"}},
        "epochs": {"ages": ["0 h", "1 year"]},
        "drift": {"falling.gain": {"ramp": "1 %/year", "relative": True}},
    }
    study = Study(GRAPH, runs=20, **tables)
    plain, compiled = (run_study(study, engine=engine) for engine in ("python", "compiled"))
    assert plain.digest == compiled.digest
    volts = (plain["high"] + plain["low"]) * 1e-3 / 2
    assert plain["bias"] == pytest.approx(volts, abs=1e-15)
    good = plain.good()
    assert good is not None
    assert good.tolist() == (volts >= 0.05).all(axis=1).tolist()
    again = replay(study, 7, 1).measures
    assert {name: again[name].value for name in plain.values} == {n: v[7, 1] for n, v in plain.values.items()}


def test_a_calibration_may_leave_one() -> None:
    study = Study(
        read_graph_text(TEXT.replace('"mV"', '"V"')),
        runs=2,
        epochs={"ages": ["0 h", "1 h"]},
        recalibration={"every": "never", "carried": {"falling.gain": "twice"}},
    )
    result = run_study(study, engine="compiled")
    assert result["low"][:, 1] == pytest.approx(-result["twice"][:, 0] * G0)
    assert run_study(study, engine="python").digest == result.digest


def test_no_value_follows_from_no_value() -> None:
    late = read_graph_text(
        TEXT.replace(
            '"rising.output", statistic = "last"', '"rising.output", statistic = "peak_to_peak", from = "2 ms"'
        )
    )
    none = simulate(late.with_parameters({"falling.gain": 0.0}), engine="python").measures
    assert none["high"].value == 0.0
    assert math.isnan(none["decibels"].value)


UNKNOWN = """
late = { signal = "rising.output", statistic = "settling_time", target = "9 V", within = "1 V" }
none = "= low - low"
part = "= late / 1 s"
"""


@pytest.mark.defect(
    "S1083", before="max(part, 0) was 0, part^0 was 1 where part has no value: limits were met", after="no value"
)
@pytest.mark.parametrize(
    "formula", ["max(part, 0)", "max(0, part)", "min(part, 3)", "min(3, part)", "part^0", "1^part", "max(log(-2), 0)"]
)
def test_no_operation_makes_a_value_of_none(formula: str) -> None:
    """What never settles has no settling time."""
    _has_none(formula)


@pytest.mark.defect("S1084", before="1 / 0 was infinite: any at_least was met, by all sensors too", after="no value")
@pytest.mark.parametrize("formula", ["1 / none", "exp(1e4)", "-exp(1e4)", "hypot(1 V / none, part)"])
def test_what_is_infinite_is_no_value(formula: str) -> None:
    _has_none(formula)


def _has_none(formula: str) -> None:
    graph = read_graph_text(TEXT.replace("[blocks]", f'{UNKNOWN}found = "= {formula}"\n[blocks]'))
    assert math.isnan(simulate(graph, engine="python").measures["found"].value)
    tables: dict[str, Any] = {"limits": {"found": {"at_least": -1e9}}, "runs": 2}
    tables["spread"] = {"rising.gain": {"normal": "1 %", "relative": True}}
    result = run_study(Study(graph, **tables), engine="python")
    assert math.isnan(result["found"][0, 0])
    assert result.yields()["found"] == 0.0


def test_they_read_back_and_differ() -> None:
    assert read_graph_text(write_graph(GRAPH)) == GRAPH
    changed = read_graph_text(TEXT.replace("(high + low) / 2", "(high + low) / 3"))
    assert [(d.key, d.before, d.after) for d in differences(GRAPH, changed)] == [
        ("measures.bias", "= (high + low) / 2", "= (high + low) / 3")
    ]


@pytest.mark.parametrize(
    ("new", "messages"),
    [
        ('"= hihg + low"', ["measures.bias: there is no value or unit hihg"]),
        ('"= high + 1 A"', ["measures.bias: a sum takes V and A"]),
        ('"= bias"', ["measures.bias: the measure depends on itself: bias -> bias"]),
        ('"= (high"', ["measures.bias: a bracket is not closed"]),
        (
            '"= other"\nother = { signal = "up.output", statistic = "lats" }',
            ["measures.other.statistic: there is no such statistic"],
        ),
    ],
)
def test_mistakes(new: str, messages: list[str]) -> None:
    text = TEXT.replace('"= (high + low) / 2"', new)
    try:
        problems = check(read_graph_text(text, "graph.toml"))
    except Exception as error:
        problems = error.problems  # type: ignore[attr-defined]
    assert [f"{problem.key}: {problem.message}" for problem in problems] == messages
    assert {problem.line for problem in problems} <= {10, 11}
