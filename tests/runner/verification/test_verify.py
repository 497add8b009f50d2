"""Requirements and golden results against closed forms, at their edges, and as files."""

import json
import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.studies.whole.study import run_study
from proofmass.runner.verification.golden import compared, read_golden, record
from proofmass.runner.verification.verify import Finding, Measurements, verify
from proofmass.runner.verification.written import findings_text, save_findings_page, save_junit

TEXT = """\
name = "an integrator in a loop"
rate = "1 kHz"
samples = 10
wires = [
    "input.output -> error.first",
    "integrator.output -> error.second",
    "error.output -> gain.input",
    "gain.output -> integrator.input",
]

[measures]
last = { signal = "input.output", statistic = "last" }
swing = { signal = "input.output", statistic = "peak_to_peak" }

[loops.main]
open_at = "gain.output"
gain_margin = "6 dB"

[requirements]
above = { quantity = "last", at_least = "2 V" }
"REQ-2.1" = { quantity = "last", at_most = "1.999 V", text = "Never <more> & more." }
swing = { quantity = "swing", at_most = "0 V" }
margin = { quantity = "main.gain_margin", at_least = "26.02 dB", at_most = "26.03 dB", at = "5 ms" }
stable = { quantity = "main.stable", at_least = "stable" }
yield = { quantity = "yield", at_least = "40 %" }
one = { quantity = "yield.last", at_most = 0.999 }

[blocks]
input = { kind = "Constant", value = "2 V", unit = "V" }
error = { kind = "Difference", unit = "V" }
gain = { kind = "Gain", gain = "100 1/s", input_unit = "V", output_unit = "V/s" }
integrator = { kind = "DiscreteIntegrator", input_unit = "V/s", output_unit = "V" }

[study]
runs = 100
spread = { "input.value" = { uniform = "1 V" } }
limits = { last = { at_least = "2 V" } }
"""
STUDY = read_study_text(TEXT)


@pytest.fixture(scope="module")
def measurements() -> Measurements:
    return Measurements(STUDY.graph, STUDY, "python")


@pytest.fixture(scope="module")
def findings(measurements: Measurements) -> dict[str, Finding]:
    return {finding.id: finding for finding in verify(measurements)}


def test_what_is_met_and_what_is_missed(findings: dict[str, Finding]) -> None:
    """The loop is k T / (z - 1) with k T = 0.1: the gain may grow twentyfold, which is 26.02 dB."""
    assert {name: finding.met for name, finding in findings.items()} == {
        "above": True,
        "REQ-2.1": False,
        "swing": True,
        "margin": True,
        "stable": True,
        "yield": True,
        "one": True,
        "main.gain_margin": True,
    }
    assert findings["above"].value == 2.0
    assert findings["margin"].value == pytest.approx(20 * math.log10(20), rel=1e-9)
    good = sum(STUDY.drawn(run)[0]["input.value"] >= 2.0 for run in range(100))
    assert findings["yield"].value == findings["one"].value == good / 100


def test_what_has_no_value_meets_nothing() -> None:
    """An unstable loop has no margins; a gain of 2100 1/s is twenty-one times the 100 1/s of the others."""
    unstable = STUDY.graph.with_parameters({"gain.gain": "2100 1/s"})  # type: ignore[attr-defined]
    found = {finding.id: finding for finding in verify(Measurements(unstable, STUDY, "python"))}
    assert math.isnan(found["main.gain_margin"].value)
    assert not found["main.gain_margin"].met
    assert not found["stable"].met
    assert found["main.gain_margin"].as_data()["value"] is None
    assert "no value" in "".join(findings_text([found["main.gain_margin"]]))


@pytest.mark.parametrize(("length", "shown"), [(60, 60), (61, 56)])
def test_long_texts_end_within_a_line(length: int, shown: int) -> None:
    finding = Finding("long", "x" * length, "gain", "", 1.0, 0.0, 2.0)
    (line,) = (line for line in findings_text([finding]) if " long " in line)
    assert line.rstrip().endswith(" " + "x" * shown + ("" if shown == length else " ..."))


def test_tables_and_files(findings: dict[str, Finding], tmp_path: Path) -> None:
    some = list(findings.values())
    lines = findings_text(some)
    assert lines[-1] == "8 requirements, 1 missed"
    assert [line.split()[0] for line in lines if "MISSED" in line or "met " in line].count("MISSED") == 1
    suite = ElementTree.parse(save_junit(tmp_path / "junit.xml", "a <graph>", some)).getroot()[0]
    assert (suite.attrib["name"], suite.attrib["tests"], suite.attrib["failures"]) == ("a <graph>", "8", "1")
    failed = {case.attrib["name"]: case[0] for case in suite if len(case)}
    assert failed.keys() == {"REQ-2.1"}
    assert failed["REQ-2.1"].text == "Never <more> & more."
    assert failed["REQ-2.1"].attrib["message"] == "last is 2 V, required <= 1.999"
    page = save_findings_page(tmp_path / "page.html", "a <graph>", some).read_text()
    assert "Never &lt;more&gt; &amp; more." in page
    assert json.loads(json.dumps([finding.as_data() for finding in some], allow_nan=False))[0]["met"] is False


def test_golden_results(measurements: Measurements, tmp_path: Path) -> None:
    path = tmp_path / "graph.golden.json"
    assert record(measurements, path) == 7  # two measures, four margins and the verdict
    assert json.loads(path.read_text())["tolerance"] == {"relative": 1e-9}
    golden = read_golden(path)
    assert all(finding.met for finding in compared(measurements, golden))
    louder = Measurements(STUDY.graph.with_parameters({"gain.gain": "100.0001 1/s"}), None, "python")  # type: ignore[attr-defined]
    missed = {finding.quantity for finding in compared(louder, golden) if not finding.met}
    assert missed == {"main.gain_margin", "main.phase_margin", "main.delay_margin", "main.sensitivity_peak"}
    data = json.loads(path.read_text())
    for name in missed:
        data["quantities"][name]["relative"] = 1e-5
    path.write_text(json.dumps(data))
    assert all(finding.met for finding in compared(louder, read_golden(path)))


def test_golden_results_of_what_is_gone(measurements: Measurements, tmp_path: Path) -> None:
    path = tmp_path / "graph.golden.json"
    record(measurements, path)
    without = read_graph_text(write_graph(STUDY.graph.changed(measures={}, requirements={})))
    findings = {f.quantity: f for f in compared(Measurements(without, None, "python"), read_golden(path))}
    assert {name for name, finding in findings.items() if not finding.met} == {"last", "swing"}


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"quantities": 3}', '{"quantities": {"a": {"value": true}}}'])
def test_files_that_are_no_golden_results(text: str, tmp_path: Path) -> None:
    path = tmp_path / "graph.golden.json"
    path.write_text(text)
    with pytest.raises(ModelError, match="is not a file of golden results"):
        read_golden(path)


@pytest.mark.defect(
    "C650",
    before="one requirement without a value ends verify: the others are not told",
    after="each answers for itself",
)
def test_a_requirement_without_a_value_says_why_and_the_others_are_verified(tmp_path: Path) -> None:
    """Without a study the yields have no value, nor has a run that ends early; margins and checks have theirs."""
    found = {finding.id: finding for finding in verify(Measurements(STUDY.graph, None, "python"))}
    assert {name for name, finding in found.items() if finding.met} == {
        "above", "swing", "margin", "stable", "main.gain_margin"
    }  # fmt: skip
    assert math.isnan(found["yield"].value)
    assert found["yield"].reason == found["one"].reason == "a yield is required, and there is no study"
    assert found["REQ-2.1"].reason == ""
    assert "yield has no value: a yield is required, and there is no study" in findings_text(list(found.values()))
    junit = save_junit(tmp_path / "found.xml", "graph", list(found.values())).read_text()
    assert junit.count("<failure") == 3
    assert "there is no study" in junit
    assert "there is no study" in save_findings_page(tmp_path / "a.html", "", list(found.values())).read_text()

    failing = TEXT.replace("samples = 10", "samples = 3000")
    diverging = read_study_text(failing.replace('gain = "100 1/s"', 'gain = "-1e6 1/s"'))
    ended = {finding.id: finding for finding in verify(Measurements(diverging.graph, None, "python"))}
    assert "not finite" in ended["above"].reason
    assert not ended["stable"].met
    assert ended["stable"].reason == ""


MISTAKES = {
    'above = { quantity = "lats", at_least = 2 }': ("there is no quantity lats", "did you mean last?"),
    'above = { quantity = "main.gain", at_least = 2 }': (
        "there is no quantity main.gain",
        "did you mean main.gain_margin?",
    ),
    'above = { quantity = "last", at_least = "2 A" }': ("A is A, not m^2*kg/s^3/A", "give it in V"),
    'above = { quantity = "last", at_least = 3, at_most = 2 }': ("nothing can meet it", ""),
    'above = { quantity = "last", at_least = 3, at = "1 s" }': (
        "is for quantities of the linearised graph",
        "",
    ),
    'above = { quantity = "last", at_least = 1, tolerances = { "integratr.gain" = "5 %" } }': (
        "there is no block integratr",
        "did you mean integrator?",
    ),
    'above = { quantity = "main.stable", at_least = "firm" }': ("there is no such verdict", "the verdicts: unstable"),
    'above = { quantity = "main.stable", at_least = 1, at = "soon" }': ("not a number followed by a unit", "20 ms"),
}


@pytest.mark.parametrize("line", MISTAKES)
def test_what_check_says(line: str) -> None:
    text = TEXT.replace('above = { quantity = "last", at_least = "2 V" }', line)
    (problem,) = check(read_graph_text(text, "graph.toml"))
    message, hint = MISTAKES[line]
    assert (problem.message, problem.line, problem.file) == (message, 20, "graph.toml")
    assert problem.key.startswith("requirements.above")
    assert hint in problem.hint


@pytest.mark.defect("H894", before="a limit of inf was missed: `inf to inf`", after="must be finite; leave it out")
@pytest.mark.parametrize("limit", ["at_least = inf", "at_most = -inf", "at_least = 1, at_most = inf"])
def test_a_limit_is_finite(limit: str) -> None:
    text = TEXT.replace('above = { quantity = "last", at_least = "2 V" }', f'above = {{ quantity = "last", {limit} }}')
    (problem,) = check(read_graph_text(text, "graph.toml"))
    assert (problem.message, problem.hint) == ("must be finite", "leave it out where there is no limit")
    assert problem.got.endswith("inf")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('above = { at_least = "2 V" }', "has no quantity"),
        ('above = { quantity = "last" }', "asks nothing"),
        ('above = { quantity = "last", at_last = 2 }', "unknown key"),
        ('above = { quantity = "last", at_least = true }', "must be a number, or a text with a unit"),
        ('above = "last >= 2 V"', "must be a table"),
        ('"a b" = { quantity = "last", at_least = 2 }', "not an id"),
    ],
)
def test_what_the_reader_says(line: str, message: str) -> None:
    with pytest.raises(ModelError) as error:
        read_graph_text(TEXT.replace('above = { quantity = "last", at_least = "2 V" }', line), "graph.toml")
    assert error.value.problems[0].message == message
    assert error.value.problems[0].line == 20


def test_they_read_back() -> None:
    assert read_graph_text(write_graph(STUDY.graph)) == STUDY.graph


LATE = """\
name = "a loop that a switch closes"
rate = "1 kHz"
duration = "40 ms"
wires = [
    "integrator.output -> closed.first",
    "switch.output -> closed.second",
    "closed.output -> minus.input",
    "minus.output -> gain.input",
    "gain.output -> integrator.input",
]

[loops.main]
open_at = "gain.output"

[requirements]
margin = { quantity = "main.gain_margin", at_least = "26.02 dB", at_most = "26.03 dB" }
start = { quantity = "main.gain_margin", at_least = "0 dB", at = "0 s" }

[blocks]
switch = { kind = "Step", start_time = "5 ms" }
closed = { kind = "Product" }
minus = { kind = "Negation" }
gain = { kind = "Gain", gain = "100 1/s", output_unit = "1/s" }
integrator = { kind = "DiscreteIntegrator", input_unit = "1/s", output_unit = "1" }

[study]
runs = 1
margins = "auto"
sweep = { "gain.gain" = ["80 1/s", "100 1/s", "125 1/s"] }
limits = { "main.gain_margin" = { at_least = "25 dB" } }
"""


@pytest.mark.defect(
    "S786", before="`verify` asked at the start, where `margins` had gone on", after="both as `margins`"
)
def test_margins_are_those_of_the_operating_point_that_is_found() -> None:
    """L = 0.1 / (z - 1) once the switch is closed: z = -1 at a gain of 20; before that nothing comes back."""
    study = read_study_text(LATE)
    findings = {finding.id: finding for finding in verify(Measurements(study.graph, study))}
    assert findings["margin"].met
    assert findings["margin"].value == pytest.approx(20.0 * math.log10(20.0))
    assert math.isnan(findings["start"].value)
    result = run_study(study, engine="python")
    expected = 20.0 * np.log10(2000.0 / np.array([80.0, 100.0, 125.0]))
    assert result["main.gain_margin"][:, 0] == pytest.approx(expected)
    assert run_study(study, engine="compiled", lanes=4).digest == result.digest
    steady = read_study_text(LATE.replace('start_time = "5 ms"', 'start_time = "0 s"'))
    side_by_side = run_study(steady, engine="compiled", lanes=4)
    assert side_by_side["main.gain_margin"][:, 0] == pytest.approx(expected)


@pytest.mark.defect(
    "S975", before="`no value` without a reason of an unstable loop, and of noise that grows", after="why"
)
def test_a_quantity_without_a_value_says_why() -> None:
    wanted = """
[requirements.walk]
quantity = { noise = "integral.output" }
at_most = 1.0
[requirements.late]
quantity = "late"
at_most = 1.0
[measures]
late = { signal = "integral.output", statistic = "mean", from = "9 s" }
[blocks.hiss]
kind = "WhiteNoise"
[blocks.integral]
kind = "DiscreteIntegrator"
"""
    text = 'name = "walk"\nrate = "1 kHz"\nsamples = 10\nwires = ["hiss.output -> integral.input"]\n' + wanted
    late, walk = sorted(verify(Measurements(read_graph_text(text), None, "python")), key=lambda one: one.id)
    assert (math.isnan(late.value), math.isnan(walk.value)) == (True, True)
    assert late.reason == "the run has no value of late"
    assert walk.reason == "the noise of integral.output grows without end"
    unstable = STUDY.graph.with_parameters({"gain.gain": "2100 1/s"})  # type: ignore[attr-defined]
    found = {finding.id: finding for finding in verify(Measurements(unstable, STUDY, "python"))}
    assert found["main.gain_margin"].reason == "the loop main is unstable"
