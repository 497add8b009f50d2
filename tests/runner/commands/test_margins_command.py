"""The command `margins`: what it says, draws and refuses; and what `check` makes of required margins."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from proofmass.graphs.files.library import library_file
from proofmass.runner.command_line import main

LOOP = str(library_file("closed_loop_accelerometer.toml"))


def said(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    assert main(list(words)) == code
    captured = capsys.readouterr()
    return captured.out + captured.err


def required(tmp_path: Path, text: str) -> str:
    path = tmp_path / "loop.toml"
    opened = 'open_at = "dac.voltage"\n'
    source = Path(LOOP).read_text(encoding="utf-8")
    assert opened in source
    path.write_text(source.replace(opened, f"{opened}{text}\n"), encoding="utf-8")
    return str(path)


@pytest.mark.exhaustive
def test_numbers_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        said(capsys, "margins", LOOP)
        == """\
loop main, opened at dac.voltage
  stable            slowest of 5 closed-loop poles: time constant 9.096 ms; time constant 803.55 us; \
556.31 Hz, damping 0.904, time constant 135.3 us
  gain margin       +31.57 dB (x 37.872)
  phase margin      90.89 deg
  delay margin      766.79 us (38.34 samples)
  disk margin       1.538
  sensitivity peak  1.06 dB at 1682.3 Hz
  bandwidth         322.6 Hz
  gain crossovers   329.25 Hz
  phase crossovers  5782.9 Hz, 25000 Hz
  linearised at     tick 0, t = 0 s
python-control agrees on main: stable, 31.57 dB, 90.89 deg
"""
    )


@pytest.mark.exhaustive
def test_numbers_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    data = json.loads(said(capsys, "margins", LOOP, "--json", "--sensitivity", "acceleration.output", "dac.code"))
    (loop,) = data["loops"]
    assert loop["stable"] is True
    assert loop["gain_margin_db"] == pytest.approx(31.566, abs=1e-3)
    assert loop["gain_reduction_db"] is None
    assert loop["delay_margin_samples"] == pytest.approx(38.34, abs=0.01)
    assert len(loop["poles"]) == 5
    assert (loop["operating_point"], loop["notes"]) == ({"tick": 0, "time_s": 0.0, "found": ""}, [])
    quantities = {entry["quantity"]: entry for entry in data["sensitivities"]}
    assert list(quantities) == ["scale factor", "bias", "main: gain margin", "main: phase margin", "main: delay margin"]
    assert quantities["scale factor"]["effects"][0]["parameter"] == "pendulosity.gain"


def test_changed_parameters_and_an_unstable_loop(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "margins", LOOP, "--set", "pickoff.gain=400000 V/rad", "--loop", "adc.number")
    assert text.startswith("loop adc.number\n  UNSTABLE")
    assert "gain margin" not in text
    data = json.loads(said(capsys, "margins", LOOP, "--set", "pickoff.gain=400000 V/rad", "--json"))
    assert data["loops"][0]["stable"] is False
    assert data["loops"][0]["gain_margin_db"] is None


@pytest.mark.exhaustive
@pytest.mark.friendly(33, "tables of parameters by their effect")
def test_tables_of_parameters(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "margins", LOOP, "--sensitivity", "acceleration.output", "dac.code")
    assert "scale factor: -8827.3967 1/(m/s^2)" in text
    assert "pendulosity.gain                       -88.27  -1.10342e+09 1/(m/s^2) per (N*m)/(m/s^2)" in text
    assert "adc.offset_error                               -413.784 1 per V" in text
    assert "and 1 more" in text


def test_sensitivity_of_a_graph_without_loops(capsys: pytest.CaptureFixture[str]) -> None:
    graph = str(library_file("recorded_motion.toml"))
    listed = json.loads(said(capsys, "margins", graph, "--json", "--sensitivity", "motion.output", "adc.number"))
    assert listed["loops"] == []
    assert [entry["quantity"] for entry in listed["sensitivities"]] == ["scale factor", "bias"]


@pytest.mark.exhaustive
def test_pictures(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "loop.svg"
    assert f"wrote {picture}" in said(capsys, "margins", LOOP, "--plot", str(picture))
    text = picture.read_text(encoding="utf-8")
    for words in ("frequency [Hz]", "|L| [dB]", "phase of L [deg]", "real part of L", "step response of L / (1 + L)"):
        assert words in text or words.replace("|", "&#124;") in text or "<!-- " + words in text
    said(capsys, "margins", LOOP, "--plot", str(picture), "--sensitivity", "acceleration.output", "dac.code")
    assert {"loop_main.svg", "loop_sensitivity.svg"} <= {path.name for path in tmp_path.iterdir()}


def test_mistakes_are_answered(capsys: pytest.CaptureFixture[str]) -> None:
    assert "did you mean main?" in said(capsys, "margins", LOOP, "--loop", "mian", code=1)
    assert "the graph has no loop" in said(capsys, "margins", str(library_file("pn_self_test_minimal.toml")), code=1)
    assert "at: " in said(capsys, "margins", LOOP, "--at", "2 V", code=1)
    assert "name a port of acceleration" in said(
        capsys, "margins", LOOP, "--sensitivity", "acceleration", "dac.code", code=1
    )


@pytest.mark.exhaustive
def test_required_margins_that_are_kept(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    kept = required(tmp_path, 'gain_margin = "31 dB"\nphase_margin = 60\ndelay_margin = "1 us"\nsensitivity_peak = 2')
    assert "ready to run" in said(capsys, "check", kept)
    assert "loop main" in said(capsys, "margins", kept)


@pytest.mark.exhaustive("margins")
@pytest.mark.parametrize("command", ["check", "margins"])
def test_required_margins_that_are_missed(command: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    missed = required(
        tmp_path, 'gain_margin = "32 dB"\nphase_margin = "91 deg"\nsensitivity_peak = 1\ndelay_margin = 1'
    )
    text = said(capsys, command, missed, code=1)
    assert "loops.main.gain_margin: the gain margin of the loop is not kept\n  got:      31.57 dB" in text
    assert "expected: at least 32 dB" in text
    assert "got:      90.89 deg\n  expected: at least 91 deg" in text
    assert "got:      1.063 dB\n  expected: at most 1 dB" in text
    assert "got:      0.0007668 s\n  expected: at least 1 s" in text
    assert "4 problems" in text


def test_an_unstable_loop_misses_everything_at_once(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    missed = required(tmp_path, 'gain_margin = "1 dB"\nphase_margin = "9 deg"')
    text = Path(missed).read_text(encoding="utf-8").replace("8.0e3 V/rad", "8.0e5 V/rad")
    Path(missed).write_text(text, encoding="utf-8")
    told = said(capsys, "check", missed, code=1)
    assert "the loop is unstable" in told
    assert "a closed-loop pole of size" in told
    assert "1 problem in" in told


def test_check_imports_no_numbers_without_requirements() -> None:
    code = (
        "import sys; from proofmass.runner.command_line import main; "
        f"assert main(['check', {LOOP!r}]) == 0; assert not {{'numpy', 'scipy', 'control'}} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


@pytest.mark.exhaustive
def test_figures_stand_before_large_libraries_are_imported() -> None:
    code = f"""
import sys
class Told:
    def find_spec(self, name, path, target=None):
        if name in ("control", "matplotlib", "scipy.optimize", "scipy.stats"):
            print("importing", name)
sys.meta_path.insert(0, Told())
from proofmass.runner.command_line import main
assert main(["margins", {LOOP!r}]) == 0
"""
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    figures, _, behind = done.stdout.partition("importing control")
    assert "linearised at" in figures
    assert "importing" not in figures
    assert "python-control agrees on main" in behind
