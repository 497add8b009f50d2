"""Graphs of the library keep their own requirements: `proofmass verify` over each that has some."""

from pathlib import Path

import pytest

from proofmass.graphs.files.library import library_files
from proofmass.runner.command_line import main

WITH_REQUIREMENTS = [
    path for path in library_files().values() if "\n[requirements]\n" in path.read_text(encoding="utf-8")
]


def test_each_kind_of_sensor_has_some() -> None:
    folders = {path.parent.name for path in WITH_REQUIREMENTS}
    assert folders >= {"accelerometer", "gyroscope", "magnetometer", "seismometer", "optical"}


@pytest.mark.exhaustive(
    "closed_loop_g",
    "closed_loop_a",
    "seismometer",
    "disk",
    "encoder",
    "hemispherical",
    "strain",
    "closed_loop_fluxgate",
    "mems_microphone",
    "michelson_accelerometer",
)
@pytest.mark.parametrize("path", WITH_REQUIREMENTS, ids=lambda path: path.stem)
def test_it_keeps_its_requirements(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["verify", str(path)])
    answer = capsys.readouterr().out
    assert code == 0, answer
    assert ", 0 missed" in answer
    assert "\nmet " in answer
