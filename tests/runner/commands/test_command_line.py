"""What the shell sees: every command, its exit codes, its messages; never a traceback for a user's error."""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import jsonschema
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.runner.command_line import cli, main

ROOT = Path(__file__).parents[3]
SELF_TEST = str(library_file("pn_self_test_minimal.toml"))

Captured = pytest.CaptureFixture[str]


@pytest.fixture
def graph(tmp_path: Path) -> str:
    """The graph that `proofmass new` writes, in a folder with a space and an umlaut."""
    folder = tmp_path / "Meßfühler 1"
    folder.mkdir()
    assert main(["new", str(folder / "sensor.toml")]) == 0
    return str(folder / "sensor.toml")


@pytest.mark.friendly(5, "new writes a graph that checks and runs")
def test_new_writes_a_graph_that_checks_and_runs_and_overwrites_nothing(graph: str, capsys: Captured) -> None:
    assert main(["check", graph]) == 0
    assert main(["run", graph]) == 0
    assert "sensor.displacement" in capsys.readouterr().out
    before = Path(graph).read_text(encoding="utf-8")
    schema = json.loads(Path(graph).with_name(before.split()[1]).read_text(encoding="utf-8"))  # that its head names
    assert jsonschema.Draft202012Validator(schema).is_valid(tomllib.loads(before))
    assert main(["new", graph]) != 0
    assert Path(graph).read_text(encoding="utf-8") == before


@pytest.mark.parametrize("command", sorted(cli.commands))
@pytest.mark.friendly(4, "every command has an example")
def test_help_has_an_example(command: str, capsys: Captured) -> None:
    assert main([command, "--help"]) == 0
    assert f"proofmass {command}" in capsys.readouterr().out


@pytest.mark.friendly(10, "0 to 3, and 2 for a misspelt command")
def test_exit_codes(graph: str, tmp_path: Path, capsys: Captured) -> None:
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(Path(graph).read_text(encoding="utf-8").replace("damping", "dampign"), encoding="utf-8")
    assert main(["check", str(wrong)]) == 1
    assert main(["run", str(wrong)]) == 1
    assert main(["run", graph, "--nonsense"]) == 2
    assert main(["rnu", graph]) == 2
    told = capsys.readouterr().err
    assert f"{wrong}:" in told
    assert "did you mean damping?" in told
    assert "did you mean run?" in told
    assert main(["run", graph, "--out", str(Path(graph) / "no_folder")]) == 3
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.friendly(9, "a traceback only when it is asked for")
def test_traceback_only_when_asked_for(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["run", graph, "--set", "sensor.mas=1"]
    assert main(words) == 1
    plain = capsys.readouterr().err
    assert "did you mean mass?" in plain
    assert "Traceback" not in plain
    command = [sys.executable, "-m", "proofmass", "--traceback", *words]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert "Traceback" in shown.stderr


@pytest.mark.friendly(14, "parameters, seed and length")
@pytest.mark.friendly(21, "a probe from the shell is recorded")
def test_set_probe_seed_and_length(graph: str, capsys: Captured) -> None:
    arguments = ["run", graph, "--json", "--samples", "200", "--probe", "readout.output", "--set", "adc.bits=8"]
    assert main([*arguments, "--set", "sensor.mass=60e-9kg", "--seed", "5"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["ticks"] == 200
    assert data["seed"] == 5
    signals = {row["signal"]: row for row in data["signals"]}
    assert set(signals) == {"sensor.displacement", "adc.code", "readout.output"}
    assert signals["adc.code"]["max"] <= 127
    assert main(["run", graph, "--duration", "10 ms", "--samples", "5"]) in (1, 2)
    assert main(["run", graph, "--duration", "5 V"]) in (1, 2)
    assert main(["run", graph, "--set", "adc.bits"]) == 2


@pytest.mark.friendly(18, "a file of blocks is used where the caller allows it")
def test_own_blocks_only_where_the_caller_allows_them(tmp_path: Path, capsys: Captured) -> None:
    own = tmp_path / "own.py"
    own.write_text(
        "from proofmass import block\n"
        '@block("V", voltage="V")\n'
        "def doubled(p, voltage: float) -> float:\n"
        '    """Twice the voltage."""\n'
        "    return 2.0 * voltage\n"
    )
    graph = tmp_path / "graph.toml"
    graph.write_text(
        'name = "own"\nrate = "1 kHz"\nsamples = 10\n'
        'wires = ["source.output -> own.voltage"]\nprobes = ["own.doubled"]\n'
        '[blocks.source]\nkind = "Constant"\nvalue = 1.5\nunit = "V"\n[blocks.own]\nkind = "Doubled"\n'
    )
    assert main(["run", str(graph)]) == 1
    assert "Doubled" in capsys.readouterr().err
    for engine in ("python", "compiled"):
        assert main(["run", str(graph), "--blocks", str(own), "--json", "--engine", engine]) == 0
        assert json.loads(capsys.readouterr().out)["signals"][0]["last"] == 3.0


def test_show_source_is_the_program_with_its_lines_of_python(capsys: Captured) -> None:
    assert main(["run", SELF_TEST, "--show-source"]) == 0
    source = capsys.readouterr().out
    assert "\ndef loop(" in source
    assert "# proofmass.blocks.calibration.correlator.update" in source
    assert "mass_spring_damper.py:37  return State(x.velocity, " in source


@pytest.mark.friendly(15, "as SVG and as text for two other programs")
def test_draw_in_three_forms(graph: str, tmp_path: Path, capsys: Captured) -> None:
    for name, start in (("a.svg", "<svg"), ("a.mmd", "flowchart"), ("a.dot", "digraph")):
        assert main(["draw", graph, "-o", str(tmp_path / name)]) == 0
        assert start in (tmp_path / name).read_text(encoding="utf-8")[:400]
    capsys.readouterr()
    assert main(["draw", graph, "--format", "mermaid"]) == 0
    assert "sensor" in capsys.readouterr().out


def test_blocks_and_schema_as_data(capsys: Captured) -> None:
    assert main(["blocks", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)) >= 40
    assert main(["blocks", "MassSprungDamper"]) == 1
    assert "did you mean MassSpringDamper?" in capsys.readouterr().err
    assert main(["schema"]) == 0
    assert "$schema" in json.loads(capsys.readouterr().out)


@pytest.mark.exhaustive
@pytest.mark.friendly(27, "netCDF, CSV and Parquet by options of a run")
def test_files_of_a_run(graph: str, tmp_path: Path, capsys: Captured) -> None:
    out = tmp_path / "out"
    assert main(["run", graph, "--out", str(out), "--format", "csv", "--format", "parquet", "--format", "netcdf"]) == 0
    names = {path.name for path in out.iterdir()}
    assert {"traces.nc", "traces.csv", "traces.parquet", "plot.svg", "summary.json", "report.html"} <= names
    assert str(out) in capsys.readouterr().out


@pytest.mark.exhaustive
@pytest.mark.friendly(23, "no bar where output is no terminal")
def test_piped_output_has_no_progress_bar() -> None:
    command = [sys.executable, "-m", "proofmass", "run", SELF_TEST, "--engine", "compiled"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=os.environ | {"NO_COLOR": "1"})
    assert done.returncode == 0
    assert done.stderr == ""
    assert "\r" not in done.stdout
    assert "\x1b" not in done.stdout


@pytest.mark.exhaustive
def test_a_command_hardly_looks_for_garbage_and_one_called_from_python_as_python_does() -> None:
    script = (
        "import gc, sys; from proofmass.runner.command_line import main; before = gc.get_threshold()\n"
        "main(['--version']); assert gc.get_threshold() == before and not gc.get_freeze_count()\n"
        "sys.argv = ['proofmass', 'check', 'library:closed_loop_accelerometer']\n"
        "seen = []; gc.callbacks.append(lambda phase, info: seen.append(phase))\n"
        "code = main(); print(code, seen.count('start') < 10, gc.get_freeze_count() > 10_000)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == "0 True True", done.stderr
