"""Studies as they travel: text and files, from which the same sensors come, or a refusal that says why."""

import dataclasses
from pathlib import Path

import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.runs.facts import facts_of
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole.study import run_study
from proofmass.runner.studies.workers.parcel import Parcel, ParcelError, packed, unpacked
from tests.by_hand.study_texts import CALIBRATED, RECORDED, RECORDING, RICH, STUDY, TRIPLE


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """A folder with a study of everything that has to travel: a recording in a folder below, and an own block."""
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "source.csv").write_text(RECORDING)
    (tmp_path / "lot.csv").write_text("offset [mV]\n1001\n999.5\n1000\n")
    (tmp_path / "triple.py").write_text(TRIPLE)
    (tmp_path / "study.toml").write_text(RECORDED)
    (tmp_path / "there").mkdir()
    return tmp_path


def recorded(here: Path) -> SensorRuns:
    return SensorRuns(read_study(here / "study.toml", load_own_blocks(here / "triple.py")), "python")


@pytest.mark.parametrize("text", [STUDY, RICH, CALIBRATED], ids=["plain", "rich", "calibrated"])
def test_the_same_sensors_come_out(text: str, here: Path) -> None:
    (here / "study.toml").write_text(text)
    sensors = SensorRuns(read_study(here / "study.toml"), "python")
    again = unpacked(packed(sensors), here / "there")
    assert again.run(3) == sensors.run(3)
    assert facts_of(again) == facts_of(sensors)
    assert list((here / "there").iterdir()) == []


def test_recordings_and_own_blocks_travel_as_content(here: Path) -> None:
    sensors = recorded(here)
    parcel = packed(sensors)
    for name in ("study.toml", "data/source.csv", "triple.py"):
        (here / name).unlink()
    again = unpacked(parcel, here / "there")
    assert again.run(2) == sensors.run(2)
    assert str(here) not in parcel.text
    assert "triple.py" in {path.name for path in (here / "there").iterdir()}


@pytest.mark.exhaustive
def test_long_lists_travel_as_files(here: Path) -> None:
    """100,000 measured values, more than the text of a study may hold."""
    values = "\n".join(f"{1000 + number / 1e5!r}" for number in range(100_000))
    (here / "lot.csv").write_text(f"offset [mV]\n{values}\n")
    (here / "study.toml").write_text(RICH)
    sensors = SensorRuns(read_study(here / "study.toml"), "python")
    again = unpacked(packed(sensors), here / "there")
    assert again.run(3) == sensors.run(3)
    assert facts_of(again) == facts_of(sensors)


@pytest.mark.exhaustive
def test_more_text_than_workers_read_is_refused_before_any_is_asked(here: Path) -> None:
    (here / "study.toml").write_text(STUDY)
    graph = read_study(here / "study.toml").graph
    large = Study(graph, runs=2, sweep={"source.value": [1.0 + number / 1e6 for number in range(60_000)]})
    with pytest.raises(ModelError, match=r"too large for workers\n.*words"):
        run_study(large, engine="python", dask="tcp://127.0.0.1:1")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"version": "0.0.1"}, "is installed there, and 0.0.1 here"),
        ({"facts": "0" * 64}, "install the same proofmass"),
        ({"text": "name = 1"}, "the study:1"),
    ],
)
def test_what_is_not_the_same_is_refused(changes: dict[str, str], said: str, here: Path) -> None:
    parcel = dataclasses.replace(packed(recorded(here)), **changes)
    with pytest.raises(ParcelError, match=said):
        unpacked(parcel, here / "there")


def test_what_was_damaged_or_edited_on_the_way_is_refused(here: Path) -> None:
    parcel = packed(recorded(here))
    with pytest.raises(ParcelError, match="damaged on its way"):
        unpacked(_with(parcel, ".csv", lambda old: old.replace(b"1.5", b"1.6")), here / "there")
    with pytest.raises(ParcelError, match="compute something different"):
        unpacked(_with(parcel, ".py", lambda old: old.replace(b"3.0", b"2.0")), here / "there")


def test_a_recording_that_was_edited_is_another_study(here: Path) -> None:
    before = facts_of(recorded(here))
    (here / "data" / "source.csv").write_text(RECORDING.replace("1.5", "1.6"))
    after = facts_of(recorded(here))
    assert {name for name in before if before[name] != after[name]} == {"recordings"}


def test_a_block_that_no_file_declares_stays_here(here: Path) -> None:
    class Mine(Block):
        """A volt."""

    @Mine.output("V")
    def output(p: Mine) -> float:
        """A volt."""
        return 1.0

    (here / "study.toml").write_text(STUDY)
    study = read_study(here / "study.toml")
    blocks = {**study.graph.blocks, "source": Mine()}
    own = Study(dataclasses.replace(study.graph, blocks=blocks), runs=2)
    with pytest.raises(ModelError, match="cannot travel"):
        packed(SensorRuns(own, "python"))


def _with(parcel: Parcel, ending: str, edited: "object") -> Parcel:
    files = tuple((n, edited(c) if n.endswith(ending) else c) for n, c in parcel.files)  # type: ignore[operator]
    return dataclasses.replace(parcel, files=files)
