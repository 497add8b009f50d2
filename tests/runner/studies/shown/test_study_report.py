"""The report of a study: whole, without network, with what came out; its commands replay what it shows."""

import dataclasses
import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study, read_study_text
from proofmass.runner.command_line import main
from proofmass.runner.studies.kept.folder import kept_result
from proofmass.runner.studies.outcome.intervals import concise
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.points import by_point
from proofmass.runner.studies.shown.report import _since_text, save_study_report
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import CALIBRATED, RECORDED, RECORDING, STUDY, TRIPLE
from tests.runner.output.test_report import Outline, texts

TEXT = STUDY.replace("seed = 11", 'seed = 11\ndesign = "saltelli"').replace("runs = 6", "runs = 40")


def reported(text: str, place: Path) -> Path:
    (place / "sensor.toml").write_text(text)
    run_study(read_study(place / "sensor.toml"), engine="compiled", folder=place / "out")
    assert main(["report", str(place / "out")]) == 0
    return place / "out"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return reported(TEXT, tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def of_two_ages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of fewer ages, without a sweep: most of the time of a report goes into its pictures."""
    text = STUDY.replace('[study.sweep]\n"filter.corner_frequency" = ["100 Hz", "200 Hz"]\n', "")
    text = text.replace(', "1000 h", "1 year"]', ', "1 year"]').replace("runs = 6", "runs = 10")
    return reported(text, tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def page(folder: Path) -> str:
    return (folder / "report.html").read_text()


@pytest.mark.exhaustive
def test_the_page_is_whole_and_asks_nothing_of_the_network(page: str) -> None:
    outline = Outline(page)
    expected = [
        "Yield",
        "Lifetimes",
        "Measures",
        "Distributions",
        "What scatters them",
        "Sobol indices",
        "Runs to look at",
    ]
    assert outline.headings == [*expected, "Study", "To repeat it"]
    assert not outline.tags & {"script", "link", "iframe", "object", "embed", "base", "img"}
    links = [value for name, value in outline.attributes if name in ("src", "href", "xlink:href", "action")]
    assert all(value.startswith("#") for value in links)
    assert not re.search(r"@import|url\((?!#)", page)
    assert "default-src 'none'" in page


@pytest.mark.exhaustive
def test_the_page_holds_what_came_out(page: str, folder: Path) -> None:
    result, text = kept_result(folder), texts(page)
    for point in by_point(result):
        for row in point.summary():
            assert concise(row["mean"], row["intervals"]["mean"]) in text
        for name, part in point.yields().items():
            assert re.search(rf"{name} .{{0,20}}{100 * part:.2f} %", text)
    assert "80 runs at 3 ages up to 1 year, 2 points of the sweep, seed 11" in text
    assert result.digest in text
    for label in (
        "bias for one standard deviation",
        "source.value [V]",
        "age [years]",
        "1 to 99 %",
        "corner_frequency = 100 Hz",
    ):
        assert label in text


@pytest.mark.parametrize(
    ("text", "since"),
    [
        (STUDY, [["", "first age", "first age"]] * 2),
        (CALIBRATED, [["0 h"] * 4, ["0 h", "0 h", "2 years", "2 years"], ["0 h", "1 year", "2 years", "3 years"]]),
    ],
)
def test_it_says_since_when_changes_are_counted(text: str, since: list[list[str]]) -> None:
    """Without calibrations from the first age on, at which nothing has changed; else from the last one."""
    result = run_study(read_study_text(text), runs=6, engine="python")
    known = StudyInfluences(result)
    for point, ages in zip(by_point(result), since, strict=True):
        said = [_since_text(result.study, found) for found in known.of(point)][::2]  # two measures at each age
        for words, age in zip(said, ages, strict=True):
            before = "last calibration, at " if text == CALIBRATED else ""
            assert words == (age and f" Changes are those since the {before}{age}.")


@pytest.mark.defect(
    "S930", before="the codes of a measure stood under another name", after="refused, with what differs"
)
def test_a_graph_that_was_changed_in_the_folder_is_refused(tmp_path: Path) -> None:
    """Rows of a ledger are in the order of measures, so that another name has the numbers of another."""
    text = STUDY.replace("[measures]\n", '[measures]\ncode = { signal = "adc.code", statistic = "last" }\n')
    run_study(read_study_text(text), runs=4, folder=tmp_path, engine="python")
    kept_result(tmp_path)
    study = tmp_path / "study.toml"
    whole = study.read_text()
    for before, after in (("\ncode =", "\nzenith ="), ('"5 V"', '"6 V"')):
        study.write_text(whole.replace(before, after))
        with pytest.raises(ModelError, match="belongs to another graph"):
            kept_result(tmp_path)


EITHER = pytest.mark.parametrize("study", ["of_two_ages", pytest.param("folder", marks=pytest.mark.exhaustive)])


@EITHER
def test_its_commands_replay_the_runs_it_names(
    study: str, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder: Path = request.getfixturevalue(study)
    capsys.readouterr()
    page = (folder / "report.html").read_text()
    monkeypatch.chdir(folder)
    result = kept_result(folder)
    rows = re.findall(r"<th>(bias|noise)</th>.*?<code>(proofmass montecarlo [^<]*)</code>", page)
    assert len(rows) == 10
    for name, command in (rows[0], rows[-1]):
        words = shlex.split(command)
        run, epoch = (int(words[words.index(w) + 1]) if w in words else 0 for w in ("--run", "--epoch"))
        assert main([*words[1:], "--json"]) == 0
        replayed = json.loads(capsys.readouterr().out)
        assert replayed["measures"][name]["value"] == result[name][run, epoch]


@pytest.mark.defect("C887", before="a report of a study that plays a recording was refused", after="written")
def test_a_study_that_plays_a_recording_is_read_back(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "source.csv").write_text(RECORDING)
    played = RECORDED.replace('kind = "Triple"', 'kind = "Gain", gain = 3')
    (tmp_path / "study.toml").write_text(played)
    ran = run_study(tmp_path / "study.toml", folder=tmp_path / "kept", engine="python")
    assert kept_result(tmp_path / "kept").digest == ran.digest


@pytest.mark.exhaustive
def test_its_commands_know_the_blocks_of_the_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "data").mkdir()
    for name, text in (("triple.py", TRIPLE), ("study.toml", RECORDED), ("data/source.csv", RECORDING)):
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    assert main(["montecarlo", "study.toml", "--blocks", "triple.py", "--out", "kept", "--quiet"]) == 0
    assert main(["report", "kept", "--blocks", "triple.py"]) == 0
    found = re.search(r"<code>(proofmass montecarlo [^<]*)</code>", (tmp_path / "kept" / "report.html").read_text())
    assert found is not None
    monkeypatch.chdir(tmp_path / "kept")
    assert main([*shlex.split(found[1])[1:], "--json"]) == 0
    assert "gain.output" in capsys.readouterr().out


@EITHER
def test_the_worst_are_those_furthest_beyond_the_limit(study: str, request: pytest.FixtureRequest) -> None:
    folder: Path = request.getfixturevalue(study)
    page, result = (folder / "report.html").read_text(), kept_result(folder)
    change = np.abs(result["bias"] / result["bias"][:, :1] - 1.0).max(axis=1) * np.abs(result["bias"][:, 0])
    named = [int(run) for run in re.findall(r"<th>bias</th>.*?--run (\d+)", page)]
    assert named == result.numbers[np.argsort(-change)[:5]].tolist()


@pytest.mark.exhaustive
def test_a_study_under_way_and_one_with_failed_runs(tmp_path: Path) -> None:
    (tmp_path / "sensor.toml").write_text(TEXT)
    study = read_study(tmp_path / "sensor.toml")
    result = run_study(study, runs=5, engine="python")
    values = {name: np.where(np.arange(10)[:, None] == 3, np.nan, result[name]) for name in result.values}
    faults = {(3, 0): "the <wire> is not a number"}
    half = dataclasses.replace(result, planned_runs=80, values=values, faults=faults)
    page = save_study_report(half, tmp_path / "page.html").read_text()
    Outline(page)
    assert "10 of 80 runs are done" in page
    assert "the &lt;wire&gt; is not a number" in page
    nothing = {name: np.full((10, 3), np.nan) for name in result.values}
    empty = save_study_report(dataclasses.replace(result, values=nothing), tmp_path / "empty.html").read_text()
    assert "What scatters them" not in Outline(empty).headings


@pytest.mark.exhaustive
def test_a_study_of_a_long_list_is_kept_with_it(tmp_path: Path) -> None:
    (tmp_path / "sensor.toml").write_text(STUDY)
    graph = read_study(tmp_path / "sensor.toml").graph
    study = Study(graph, runs=3, spread={"source.value": {"values": [1.0 + number / 1e6 for number in range(70_000)]}})
    made = run_study(study, engine="python", folder=tmp_path / "out")
    assert kept_result(tmp_path / "out").digest == made.digest
    page = save_study_report(made, tmp_path / "out" / "report.html").read_text()
    assert len(page) < 200_000


def test_a_folder_without_a_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == 1
    assert "holds no study" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_a_study_file_stands_for_the_folder_it_ran_in_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, here = tmp_path / "studies" / "sensor.toml", tmp_path / "here"
    path.parent.mkdir()
    path.write_text(STUDY)
    (tmp_path / "other.toml").write_text(STUDY.replace("200 ppm", "300 ppm"))
    assert main(["report", str(path)]) == 1
    assert "no folder of this study is beside the file or here" in capsys.readouterr().err
    run_study(read_study(path), runs=2, engine="python", folder=path.parent / "beside")
    (path.parent / "beside").rename(path.parent / "moved")
    run_study(read_study(tmp_path / "other.toml"), runs=2, engine="python", folder=here / "other")
    monkeypatch.chdir(here)
    assert main(["report", str(path)]) == 0
    assert "moved/report.html" in capsys.readouterr().out
    run_study(read_study(path), runs=3, seed=4, engine="python", folder=here / "out")
    assert main(["report", str(path)]) == 0
    assert "wrote out/report.html: 6 of 6 runs" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_margins_of_the_runs_are_in_the_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Measures of the ledger that no signal has."""
    text = library_file("scale_factor_drift.toml").read_text().partition("[study]")[0]
    text = text.replace('duration = "0.3 s"', 'duration = "1 ms"').replace('from = "0.25 s"', 'from = "0 s"')
    more = '[study]\nruns = 2\nmargins = "0 s"\n[study.spread]\n"pickoff.gain" = { normal = "1 %", relative = true }\n'
    (tmp_path / "study.toml").write_text(text + more)
    made = run_study(read_study(tmp_path / "study.toml"), engine="python", folder=tmp_path / "out")
    assert kept_result(tmp_path / "out").digest == made.digest
    capsys.readouterr()
    assert main(["report", str(tmp_path / "out"), "--json"]) == 0
    assert "main.gain_margin" in texts((tmp_path / "out" / "report.html").read_text())
    data = json.loads(capsys.readouterr().out)
    assert (data["digest"], data["report"]) == (made.digest, str(tmp_path / "out" / "report.html"))
    assert "main.gain_margin" in [measure["measure"] for measure in data["measures"]]


@pytest.mark.exhaustive
def test_one_age_and_no_limits(tmp_path: Path) -> None:
    (tmp_path / "sensor.toml").write_text(STUDY.partition("[study.sweep]")[0])
    result = run_study(read_study(tmp_path / "sensor.toml"), engine="python")
    page = save_study_report(result, tmp_path / "page.html").read_text()
    assert Outline(page).headings[:3] == ["Measures", "Distributions", "What scatters them"]
    assert "age [" not in page
    assert "from the median" in page


@pytest.mark.exhaustive
def test_intervals_between_calibrations_stand_under_headings(tmp_path: Path) -> None:
    """Each has its own yield and measures; of 41 epochs eleven are in the tables."""
    limit = "\n[study.limits]\nfound = { at_most = 1.03 }\n"
    (tmp_path / "study.toml").write_text(CALIBRATED.replace('until = "4 year"', 'until = "40 year"') + limit)
    result = run_study(read_study(tmp_path / "study.toml"), runs=2, engine="python")
    page = save_study_report(result, tmp_path / "report.html").read_text()
    for words in ("Never recalibrated", "Recalibrated every 2 years", "Recalibrated every year"):
        assert page.count(f"<h3>{words}</h3>") == 3
    assert "3 intervals between calibrations" in page
    assert "points of the sweep" not in page
    measures = page[page.index(">Measures<") : page.index(">Distributions<")]
    assert measures.count("found") == 3 * 11
    assert "40 years" in measures
    assert "39 years" not in measures
