"""Saving from a live page: numbers into the one file that may be written, comments kept, undone to the byte."""

from pathlib import Path
from typing import Any

import pytest

from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from proofmass.runner.live.session import Session

GRAPH = """# a loop that is none
name = "two blocks"\r
rate = "1 kHz"
samples = 100
wires = ["push.output -> meter.voltage"]

[values]
height = "2 mV"   # of the step

[blocks.push]
kind = "Step"
start_time = "10 ms"  # after the start
amplitude = "= 2 * height"
unit = "V"

[blocks.meter]
kind = "AnalogToDigital"
bits = 12 # of them
"""


def state(**values: float) -> dict[str, Any]:
    named = {name.replace("__", "."): value for name, value in values.items()}
    return {"state": {"values": named, "seed": "1", "duration": "0.1"}}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "graph.toml"
    path.write_bytes(GRAPH.encode())
    return path


@pytest.fixture
def session(file: Path) -> Session:
    made = Session(file, lambda: read_graph(file), edit=True)
    assert made.reload() == []
    return made


def test_values_are_written_in_the_units_of_the_file_and_undone_to_the_byte(file: Path, session: Session) -> None:
    assert session.change({"changes": {"meter.bits": "14"}})
    assert session.save(state(push__start_time=0.0125, height=2.5e-3, meter__reference=4.096)) == {"undo": 1}
    expected = GRAPH.replace('"10 ms"', '"12.5 ms"').replace('"2 mV"', '"2.5 mV"').replace("bits = 12", "bits = 14")
    lines = expected.splitlines(keepends=True)
    assert file.read_bytes() == "".join([*lines, 'reference = "4.096 V"\n']).encode()
    assert session.reload() == []
    assert session.save(state(push__start_time=0.02)) == {"undo": 2}
    assert session.undo({}) == {"undo": 1}
    assert session.undo({}) == {"undo": 0}
    assert session.undo({}) == {"undo": 0}
    assert file.read_bytes() == GRAPH.encode()


def test_what_an_editor_has_written_since_is_not_undone(file: Path, session: Session) -> None:
    assert session.save(state(push__start_time=0.02)) == {"undo": 1}
    theirs = file.read_bytes() + b"# mine\n"
    file.write_bytes(theirs)
    answer = session.undo({})
    assert answer is not None
    assert answer["problems"][0]["message"] == "has changed since it was saved from the page"
    assert file.read_bytes() == theirs


@pytest.mark.parametrize(
    "data",
    [
        None,
        {},
        state(push__nothing=1.0),
        state(**{'push__start_time"\nseed': 1.0}),
        {"state": {"values": {"push.start_time": '1 s"\nseed = "3'}, "seed": "1", "duration": "1"}},
        {"state": {"values": {"push.start_time": float("inf")}, "seed": "1", "duration": "1"}},
    ],
)
def test_only_numbers_of_known_sliders_are_written(file: Path, session: Session, data: object) -> None:
    assert session.save(data) is None
    assert file.read_bytes() == GRAPH.encode()


def test_nothing_is_written_without_leave(file: Path) -> None:
    session = Session(file, lambda: read_graph(file))
    session.reload()
    assert session.save(state(push__start_time=0.02)) is None
    assert session.undo({}) is None
    assert file.read_bytes() == GRAPH.encode()


def test_graphs_of_the_library_and_in_python_are_not_edited(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["live", "library:closed_loop_accelerometer", "--edit", "--no-browser"]) == 1
    assert "a graph of the library" in capsys.readouterr().err
    assert main(["new", "sensor.py"]) == 0
    assert main(["live", "sensor.py", "--edit", "--no-browser"]) == 1
    assert "a TOML file" in capsys.readouterr().err
