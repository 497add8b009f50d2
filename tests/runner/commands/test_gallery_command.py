"""The gallery as a user sees it, and copies of it that run."""

import json
from pathlib import Path

import pytest

from proofmass.graphs.files.gallery import PARTS, exhibits
from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from proofmass.runner.commands.schema_command import SCHEMA_FILE, STUDY_SCHEMA_FILE

GALLERY = exhibits()


def said(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    assert main(list(words)) == code
    shown = capsys.readouterr()
    return shown.err if code else shown.out


def test_every_graph_has_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "gallery")
    files = {name.removesuffix(".toml") for name in library_files() if name.endswith(".toml")} - {"template"}
    assert {line.split()[0] for line in text.splitlines() if line.startswith("  ")} == files
    assert all(len(line) <= 120 for line in text.splitlines())
    listed = json.loads(said(capsys, "gallery", "--json"))
    assert {one["name"] for one in listed} == files
    assert all(one["title"] for one in listed)


def test_one_graph(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "gallery", "quartz_thermometer")
    assert text.startswith("quartz_thermometer: quartz thermometer of frequency output\n")
    assert "proofmass new sensor.toml --from quartz_thermometer" in text
    assert "did you mean quartz_thermometer?" in said(capsys, "gallery", "quarz_thermometer", code=1)


@pytest.mark.parametrize(
    "name", ["recorded_motion", "quartz_drift_study.toml", "resonator_loop", "closed_loop_gyroscope"]
)
def test_copies(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With the files beside them, so that they are checked where they now lie."""
    copy = tmp_path / "mine.toml"
    assert "wrote" in said(capsys, "new", str(copy), "--from", name)
    original = next(one for one in GALLERY if one.name == name.removesuffix(".toml"))
    assert copy.read_text() == original.path.read_text()
    files = [copy, *(tmp_path / file for file in original.beside if file.endswith(".toml"))]
    schemas = {file.read_text(encoding="utf-8").partition("\n")[0].removeprefix("#:schema ") for file in files}
    assert schemas <= {SCHEMA_FILE, STUDY_SCHEMA_FILE}
    assert {path.name for path in tmp_path.iterdir()} == {"mine.toml", *schemas, *original.beside}
    if original.family == PARTS:
        assert read_graph(copy).exports
    else:
        said(capsys, "check", str(copy))


def test_nothing_is_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "recorded_motion.csv").write_text("mine")
    text = said(capsys, "new", str(tmp_path / "a.toml"), "--from", "recorded_motion", code=2)
    assert "recorded_motion.csv exists already; nothing was written" in text
    assert [path.name for path in tmp_path.iterdir()] == ["recorded_motion.csv"]
    assert (tmp_path / "recorded_motion.csv").read_text() == "mine"
    assert "no such graph" in said(capsys, "new", str(tmp_path / "b.toml"), "--from", "../secrets", code=1)
