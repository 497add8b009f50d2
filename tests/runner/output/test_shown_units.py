"""Quantities are shown in the unit in which they were written, or in that which a probe or a measure asks for."""

import math
import pickle
import re
from pathlib import Path

import pytest

from proofmass.blocks.declaration.instance import written
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.shown_units import pretty
from proofmass.blocks.mechanics.mass_spring_damper import MassSpringDamper
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.graph import Graph
from proofmass.runner.commands.run_text import run_lines
from proofmass.runner.output.plot import plot_traces
from proofmass.runner.output.report import save_report
from proofmass.runner.run.simulate import simulate

TEXT = """
name = "turning"
rate = "10 Hz"
samples = 11
wires = ["rate.output -> lag.input"]
probes = [{ signal = "rate.output", unit = "deg/h" }, "lag.output"]
[measures]
drift = { signal = "lag.output", statistic = "last", unit = "deg/h" }
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


def test_a_probe_and_a_measure_are_shown_in_their_units_and_kept_in_those_of_the_port(tmp_path: Path) -> None:
    result = simulate(graph_of(TEXT), engine="python")
    plain = simulate(graph_of(TEXT.replace(', unit = "deg/h"', "")), engine="python")
    assert result.digest == plain.digest
    trace = result["rate.output"]
    assert (trace.unit, trace.values[0]) == ("rad/s", math.radians(15.0) / 3600.0)
    text = "\n".join(run_lines(result))
    assert re.search(r"rate\.output +°/h +11 +15 +\d\S* +15 +15 +15\n", text)
    drift = 15.0 * -math.expm1(-2 * math.pi * 2.0 * 1.0)
    assert f"drift = {drift:.6g} °/h: last of lag.output" in text
    assert result.measures["drift"].unit == "rad/s"
    labels = [axes.get_ylabel() for axes in plot_traces(result).axes]
    assert labels == ["rate.output [°/h]", "lag.output [µrad/s]"]
    page = save_report(result, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "15 °/h" in page
    assert "2000 mHz" in page
    assert "corner_frequency = &quot;2000 mHz&quot;" in page


def test_a_unit_of_another_kind_is_refused_and_one_that_is_none() -> None:
    first, second = check(graph_of(TEXT.replace("deg/h", "deg").replace('"15 deg"', "0")))
    assert (first.key, first.message) == ("probes: rate.output", "cannot be shown in deg: it is in rad/s")
    assert (second.key, second.message) == ("measures.drift.unit", "cannot be shown in deg: it is in rad/s")
    with pytest.raises(ModelError) as refused:
        graph_of(TEXT.replace('unit = "deg/h"', 'unit = "dgee/h"'))
    assert [problem.message for problem in refused.value.problems] == ["unknown unit 'dgee'"] * 2


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
