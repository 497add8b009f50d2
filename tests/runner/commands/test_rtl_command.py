"""The command `rtl`: what it writes, says and refuses."""

import json
from pathlib import Path

import pytest

from proofmass.graphs.files.library import library_file
from proofmass.runner.command_line import main

CALIBRATION = str(library_file("self_calibration_fixed.toml"))


def said(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    assert main(["rtl", *words]) == code
    captured = capsys.readouterr()
    return captured.out + captured.err


def test_the_digital_part_of_a_graph_is_written(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = tmp_path / "new" / "hardware"
    text = said(capsys, CALIBRATION, "-o", str(folder), "--ticks", "40")
    assert "shift_register: 10 register bits\n" in text
    assert "fixed_mass_spring_damper: 64 register bits, 545 adder bits, multipliers 32 x 24 (2), by constants" in text
    names = {path.name for path in folder.iterdir()}
    stem = "self_calibration_fixed"
    assert names == {
        f"{stem}.v", f"{stem}_bench.v", f"{stem}_inputs.hex", f"{stem}_outputs.hex", "report.html", "report.json",
    }  # fmt: skip
    assert (folder / f"{stem}.v").read_text(encoding="utf-8").count("endmodule") == 10
    assert len((folder / f"{stem}_inputs.hex").read_text(encoding="utf-8").splitlines()) == 40


def test_one_block_with_another_parameter_as_json(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = (CALIBRATION, "--block", "chips", "-o", str(tmp_path), "--ticks", "30", "--set", "chips.seed=5", "--json")
    assert main(["rtl", *words]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["top"] == "shift_register"
    assert data["modules"][0]["registers"][0]["reset"] == 5
    assert "cells <= 10'd5;" in (tmp_path / "shift_register.v").read_text(encoding="utf-8")


def test_sums_may_be_merged(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = (CALIBRATION, "--block", "stiffness", "-o", str(tmp_path), "--ticks", "1")
    said(capsys, *words)
    kept = (tmp_path / "fixed_stiffness_controller.v").read_text(encoding="utf-8")
    said(capsys, *words, "--merge-adders")
    assert "keep" in kept
    assert "keep" not in (tmp_path / "fixed_stiffness_controller.v").read_text(encoding="utf-8")


LOOPED = """from proofmass import Block, Input

class Looped(Block):
    \"\"\"A code that says how often a loop is run.\"\"\"
    code = Input("1", "Code.", dtype=int)

@Looped.output("1")
def ones(p, code: int) -> int:
    \"\"\"So many ones.\"\"\"
    count = 0
    for _ in range(code):
        count = count ^ 1
    return count
"""
LOOPED_GRAPH = """name = "looped"
rate = "1 kHz"
samples = 10
wires = ["counter.count -> looped.code"]
probes = ["looped.ones"]
[blocks.counter]
kind = "Counter"
[blocks.looped]
kind = "Looped"
"""


def test_a_loop_that_a_signal_bounds_is_told_with_its_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(LOOPED)
    (tmp_path / "looped.toml").write_text(LOOPED_GRAPH)
    words = (str(tmp_path / "looped.toml"), "--blocks", str(tmp_path / "own.py"), "-o", str(tmp_path / "hardware"))
    text = said(capsys, *words, code=1)
    assert "own.py:11: blocks.looped.ones: a signal bounds a loop or indexes a list" in text
    assert not (tmp_path / "hardware").exists()


@pytest.mark.exhaustive
def test_what_is_wrong_is_told_and_nothing_is_written(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = tmp_path / "hardware"
    text = said(capsys, CALIBRATION, "--block", "stifness", "-o", str(folder), code=1)
    assert "blocks.stifness: no such block" in text
    assert "did you mean stiffness?" in text
    text = said(capsys, str(library_file("pn_self_test_minimal.toml")), "-o", str(folder), code=1)
    assert "correlator.py:49: blocks.correlator.correlator: sums: sums grows without bound" in text
    text = said(capsys, str(library_file("closed_loop_accelerometer.toml")), "-o", str(folder), code=1)
    assert "the graph has no digital blocks" in text
    assert "-o" in said(capsys, CALIBRATION, code=2)
    assert not folder.exists()
