"""Every command of the gallery runs, and those that show margins say that loops are stable."""

import re
import shlex
from pathlib import Path

import pytest

from proofmass.runner.command_line import main
from tests.documents.test_gallery import DOCS

EVERY = re.findall(r"^    proofmass (.*)$", (DOCS / "gallery.md").read_text("utf-8"), re.MULTILINE)
COMMANDS = [command for command in EVERY if command.startswith("margins ")]
OF_ONE_BIT = "sigma_delta"  # its gain is a guess of the reader


@pytest.mark.exhaustive
def test_all_commands_run_one_after_the_other_from_an_empty_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(EVERY) > 60
    for command in EVERY:
        assert main(shlex.split(command)) == 0, command


@pytest.mark.exhaustive
@pytest.mark.parametrize("command", [each for each in COMMANDS if OF_ONE_BIT not in each])
def test_loops_are_stable(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(shlex.split(command)) == 0
    shown = capsys.readouterr().out
    assert "UNSTABLE" not in shown
    assert "phase margin" in shown


@pytest.mark.exhaustive
@pytest.mark.defect(
    "S699",
    before="the fibre-optic gyroscope at rest, as the gallery shows it, is unstable: it grows by e in ten years",
    after="stable, and two integrators that its loop does not see",
)
def test_the_fibre_optic_gyroscope_at_rest(capsys: pytest.CaptureFixture[str]) -> None:
    (command,) = (each for each in COMMANDS if "fibre" in each)
    assert main(shlex.split(command)) == 0
    assert "phase margin      81.47 deg" in capsys.readouterr().out
