"""Quantities are shown in the unit in which they were written, or in that which a probe or a measure asks for."""

import math
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declaration.instance import written
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.shown_units import pretty
from proofmass.blocks.mechanics.mass_spring_damper import MassSpringDamper
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.commands.run_text import run_lines
from proofmass.runner.commands.study_files import study_data
from proofmass.runner.live.model import live_model
from proofmass.runner.output.plot import plot_traces
from proofmass.runner.output.report import save_report
from proofmass.runner.output.sweeps import plot_sweep, sweep_lines
from proofmass.runner.run.simulate import simulate
from proofmass.runner.run.sweep import sweep
from proofmass.runner.studies.shown.plot import plot_study
from proofmass.runner.studies.shown.report import save_study_report
from proofmass.runner.studies.shown.text import study_text
from proofmass.runner.studies.whole.study import run_study

TEXT = """
name = "turning"
rate = "10 Hz"
samples = 11
wires = ["rate.output -> lag.input"]
probes = [{ signal = "rate.output", unit = "deg/h" }, "lag.output"]
[measures]
drift = { signal = "lag.output", statistic = "last", unit = "deg/h" }
twice = { formula = "= 2 * drift", unit = "deg/h" }
[blocks.rate]
kind = "Constant"
value = "15 deg/h"
unit = "rad/s"
[blocks.lag]
kind = "LowPass"
corner_frequency = "2000 mHz"
input_unit = "rad/s"
output_unit = "rad/s"
"""


def graph_of(text: str) -> Graph:
    return read_graph_text(text)


@pytest.mark.friendly(13, "results are in the units that are asked for")
def test_a_probe_and_a_measure_are_shown_in_their_units_and_kept_in_those_of_the_port(tmp_path: Path) -> None:
    result = simulate(graph_of(TEXT), engine="python")
    plain = simulate(graph_of(TEXT.replace(', unit = "deg/h"', "")), engine="python")
    assert result.digest == plain.digest
    assert result.measures["twice"].value == plain.measures["twice"].value == 2.0 * plain.measures["drift"].value
    trace = result["rate.output"]
    assert (trace.unit, trace.values[0]) == ("rad/s", math.radians(15.0) / 3600.0)
    text = "\n".join(run_lines(result))
    assert re.search(r"rate\.output +°/h +11 +15 +\d\S* +15 +15 +15\n", text)
    drift = 15.0 * -math.expm1(-2 * math.pi * 2.0 * 1.0)
    assert f"drift = {drift:.6g} °/h: last of lag.output" in text
    assert result.measures["drift"].unit == "rad/s"
    assert f"twice = {2 * drift:.6g} °/h: = 2 * drift" in text
    data = result.measures["twice"].as_data()
    assert (data["unit"], data["shown_in"]) == ("rad/s", "deg/h")
    assert data["value"] == pytest.approx(2 * math.radians(drift) / 3600.0, rel=1e-12)
    labels = [axes.get_ylabel() for axes in plot_traces(result).axes]
    assert labels == ["rate.output [°/h]", "lag.output [µrad/s]"]
    page = save_report(result, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "15 °/h" in page
    assert "2000 mHz" in page
    assert "corner_frequency = &quot;2000 mHz&quot;" in page


def test_a_unit_of_another_kind_is_refused_and_one_that_is_none() -> None:
    first, second, third = check(graph_of(TEXT.replace("deg/h", "deg").replace('"15 deg"', "0")))
    assert (first.key, first.message) == ("probes: rate.output", "cannot be shown in deg: it is in rad/s")
    assert (second.key, second.message) == ("measures.drift.unit", "cannot be shown in deg: it is in rad/s")
    assert (third.key, third.message) == ("measures.twice.unit", "cannot be shown in deg: it is in rad/s")
    with pytest.raises(ModelError) as refused:
        graph_of(TEXT.replace('unit = "deg/h"', 'unit = "dgee/h"'))
    assert [problem.message for problem in refused.value.problems] == ["unknown unit 'dgee'"] * 3


@pytest.mark.parametrize(
    ("entry", "key", "message"),
    [
        ('{ formula = "= 2 * drift", united = "deg/h" }', "measures.twice.united", "unknown key"),
        ("{ formula = 2.0 }", "measures.twice.formula", "must be a text that begins with ="),
        ('{ formula = "= 2 *" }', "measures.twice.formula", "ends too early"),
    ],
)
def test_a_measure_of_measures_with_a_unit_is_a_table_of_two_keys(entry: str, key: str, message: str) -> None:
    with pytest.raises(ModelError) as refused:
        graph_of(TEXT.replace('{ formula = "= 2 * drift", unit = "deg/h" }', entry))
    (problem,) = refused.value.problems
    assert (problem.key, problem.line) == (key, 9)
    assert message in problem.message


STUDY = """
graph = "turning.toml"
runs = 12
[spread]
"rate.value" = { normal = "1 deg/h" }
[limits]
drift = { at_most = "15 deg/h" }
"""


@pytest.mark.exhaustive
@pytest.mark.friendly(13, "so are those of studies")
def test_a_study_is_shown_in_the_units_of_its_measures_and_kept_in_those_of_the_signals(tmp_path: Path) -> None:
    (tmp_path / "turning.toml").write_text(TEXT)
    (tmp_path / "study.toml").write_text(STUDY)
    study = read_study(tmp_path / "study.toml")
    result = run_study(study, engine="python")
    mean, scale = float(result["drift"].mean()), 3600.0 * 180.0 / math.pi
    rows = {line.split()[0]: line.split() for line in study_text(result).splitlines() if "deg/h" in line}
    assert {name: row[1] for name, row in rows.items()} == {"drift": "deg/h", "twice": "deg/h"}
    for name, factor in (("drift", scale), ("twice", 2.0 * scale)):
        shown, bracket = rows[name][4].rstrip(")").split("(")
        assert float(shown) == pytest.approx(mean * factor, rel=2e-2)
        assert bracket.isdigit()
    assert f"{100 * result.yields()['drift']:.2f} %" in study_text(result)
    assert {m["measure"]: m["unit"] for m in study_data(result)["measures"]} == {"drift": "rad/s", "twice": "rad/s"}
    assert study_data(result)["measures"][0]["mean"] == pytest.approx(mean, rel=1e-12)
    assert [panel.get_xlabel() for panel in plot_study(result).axes] == ["drift [°/h]", "twice [°/h]"]
    assert f">{scale * mean:.6g}</td>" in result._repr_html_()
    page = save_study_report(result, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "≤ 15 °/h<" in page
    assert result.digest in page
    assert "at_most = 7.272" in page, "the file to repeat it has the units of the signals"


def test_a_sweep_is_shown_in_the_units_of_its_measures() -> None:
    graph = graph_of(TEXT)
    swept = sweep(graph, {"lag.corner_frequency": [1.0, 3.0]}, engine="python")
    head, *rows = (re.split(r"  +", line.strip()) for line in sweep_lines(swept, ["drift", "twice"]))
    assert head == ["lag.corner_frequency", "drift [deg/h]", "twice [deg/h]"]
    for row, corner in zip(rows, (1.0, 3.0), strict=True):
        drift = 15.0 * -math.expm1(-2 * math.pi * corner)
        assert [float(cell) for cell in row] == pytest.approx([corner, drift, 2.0 * drift], rel=1e-8)
    (panel, other) = plot_sweep(swept, ["drift", "twice"]).axes
    assert (panel.get_ylabel(), other.get_ylabel()) == ("drift [°/h]", "twice [°/h]")
    assert np.asarray(panel.lines[0].get_ydata())[0] == pytest.approx(15.0 * -math.expm1(-2 * math.pi), rel=1e-8)


def test_a_live_page_has_the_scales_of_the_units_that_are_asked_for() -> None:
    model = live_model(graph_of(TEXT))
    probe = next(one for one in model["loop"]["probes"] if one["signal"] == "rate.output")
    for one in (probe, model["loop"]["measures"][0]):
        (scale,) = model["units"][one["unit"]]
        assert 10.0 ** -scale["exponent"] == pytest.approx(3600.0 * 180.0 / math.pi, rel=1e-12)
        assert scale["text"] == "°/h"


@pytest.mark.friendly(13, "quantities keep how they were written")
def test_what_was_written_stays_with_a_block_and_changes_nothing() -> None:
    text, number = MassSpringDamper(mass="50.43 ug"), MassSpringDamper(mass=50.43e-9)
    assert text == number
    assert hash(text) == hash(number)
    assert written(pickle.loads(pickle.dumps(text)), "mass") == "50.43 ug"
    graph = graph_of(TEXT)
    changed = graph.with_parameters({"rate.value": "1 rad/min", "lag.corner_frequency": 3.0})
    assert written(changed.blocks["rate"], "value") == "1 rad/min"
    assert written(changed.blocks["lag"], "corner_frequency") == ""
    again = write_graph(graph, as_written=True)
    assert 'value = "15 deg/h"' in again
    assert write_graph(graph_of(again)) == write_graph(graph)
    assert pretty("deg/h") == "°/h"
