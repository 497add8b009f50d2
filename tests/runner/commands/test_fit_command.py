"""`proofmass fit` as the shell sees it: tables, graphs, coefficients written into a graph, exit codes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from tests.by_hand.temperature_sets import M1, TEMPERATURE

TABLE = str(library_file("zero_bias_m1.csv"))
GRAPH = library_file("temperature_compensation_m1.toml")
SIGNALS = ["--temperature", "thermometer.voltage", "--output", "noisy.output"]

Captured = pytest.CaptureFixture[str]


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    """The graph of M1 with models that are not fitted yet."""
    lines = GRAPH.read_text(encoding="utf-8").splitlines(keepends=True)
    starts = [i for i, line in enumerate(lines) if line.startswith(("[blocks.model]", "[blocks.digital]"))]
    kept = [line for i, line in enumerate(lines) if not (line[0] in "ab" and any(s < i < s + 6 for s in starts))]
    path = tmp_path / "graph.toml"
    path.write_text("".join(kept), encoding="utf-8")
    return path


def model(path: Path, name: str = "model") -> dict[str, float]:
    graph = read_graph(path)
    block = graph.subgraphs[name].blocks["memory"] if name in graph.subgraphs else graph.blocks[name]
    return {p: getattr(block, p) for p in type(block).parameters if p[1:].isdigit()}


@pytest.mark.exhaustive
def test_a_graph_calibrates_itself(graph: Path, capsys: Captured) -> None:
    before = graph.read_text(encoding="utf-8")
    assert model(graph) != model(GRAPH)
    assert main(["fit", str(graph), *SIGNALS, "--write", str(graph)]) == 0
    assert f"wrote {graph}" in capsys.readouterr().out
    assert model(graph) == pytest.approx(model(GRAPH), rel=1e-6)
    assert model(graph, "digital") == model(graph), "what a subgraph exports is fitted too"
    assert set(before.splitlines()) < set(graph.read_text(encoding="utf-8").splitlines())
    assert main(["run", str(graph), "--json"]) == 0
    signals = {row["signal"]: row for row in json.loads(capsys.readouterr().out)["signals"]}
    compensated = signals["compensated.output"]
    assert compensated["max"] - compensated["min"] == pytest.approx(M1.after, rel=1e-3)
    assert abs(compensated["mean"]) < 1e-6


@pytest.mark.exhaustive
def test_a_table_as_json_and_as_a_picture(tmp_path: Path, capsys: Captured) -> None:
    picture = tmp_path / "fit.png"
    assert main(["fit", TABLE, "--json", "--plot", str(picture), "--order", "5", "--start", "-1", "1"]) == 0
    out, err = capsys.readouterr()
    fits = json.loads(out)["fits"]
    assert [fitted["model"] for fitted in fits] == ["two exponentials", "two exponentials", "polynomial of order 5"]
    assert fits[1]["iterations"] == M1.iterations
    assert err == f"wrote {picture}\n"
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_starts_of_a_grid(capsys: Captured, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proofmass.runner.design.fit.alternation.MOST_ITERATIONS", 20)
    assert main(["fit", TABLE, "--starts"]) == 0
    told = capsys.readouterr().out
    assert "alternation: 0 of 45 starts reach the optimum" in told
    assert "variable projection: 44 of 45 starts reach the optimum" in told


@pytest.mark.exhaustive
def test_offset_is_taken_off(tmp_path: Path, capsys: Captured) -> None:
    path = tmp_path / "raised.csv"
    rows = [f"{t!r},{v + 2.5!r}" for t, v in zip(TEMPERATURE.tolist(), M1.output().tolist(), strict=True)]
    path.write_text("\n".join(["sensor,bias", *rows]), encoding="utf-8")
    assert main(["fit", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["determined"] is False
    assert main(["fit", str(path), "--json", "--offset", "2.5"]) == 0
    assert json.loads(capsys.readouterr().out)["fits"][0]["rmse"] == pytest.approx(M1.rmse[0], rel=1e-4)


@pytest.mark.exhaustive
def test_polynomials_and_any_block_with_such_parameters(graph: Path) -> None:
    text = graph.read_text(encoding="utf-8").replace("DoubleExponentialModel", "PolynomialModel")
    graph.write_text(text + '\n[blocks.simulated]\nkind = "ZeroBiasVoltage"\n', encoding="utf-8")
    assert main(["fit", TABLE, "--write", str(graph), "--order", "4", "--order", "3"]) == 0
    found = model(graph)
    assert found["c4"] == pytest.approx(0.012867109, rel=1e-6)
    assert found["c5"] == found["c6"] == 0.0
    assert main(["fit", TABLE, "--write", str(graph), "--block", "simulated"]) == 0
    assert model(graph, "simulated")["b1"] == pytest.approx(-5.9936064, rel=1e-6)
    assert model(graph) == found


def test_the_memory_and_the_polynomial_of_a_digital_compensation(tmp_path: Path) -> None:
    path = tmp_path / "digital.toml"
    blocks = (
        '[blocks.memory]\nkind = "FixedCoefficientMemory"\n[blocks.polynomial]\nkind = "FixedPolynomial"\norder = 4\n'
    )
    path.write_text(f'rate = "1 Hz"\nduration = "1 s"\n{blocks}', encoding="utf-8")
    assert main(["fit", TABLE, "--write", str(path)]) == 0
    assert model(path, "memory")["b2"] == pytest.approx(1.5061774, rel=1e-6)
    assert model(path, "polynomial")["c4"] == pytest.approx(0.012867109, rel=1e-6)


def test_nothing_is_written_where_nothing_is_determined(graph: Path, tmp_path: Path, capsys: Captured) -> None:
    line, before = tmp_path / "line.csv", graph.read_bytes()
    line.write_text("T [V],bias [V]\n" + "".join(f"{t},{3 * t}\n" for t in range(1, 20)), encoding="utf-8")
    assert main(["fit", str(line), "--write", str(graph)]) == 1
    out, err = capsys.readouterr()
    assert "two exponentials" in out, "the report is shown all the same"
    assert "cannot be told apart" in err
    assert "nothing was written" in err
    assert graph.read_bytes() == before


@pytest.mark.exhaustive("arguments7")
@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        (["none.csv"], 1, "there is no such file"),
        ([TABLE, "--temperature", "senser"], 1, "did you mean sensor?"),
        ([TABLE, "--write", "none.toml"], 1, "none.toml: cannot be read"),
        ([TABLE, "--write", "GRAPH", "--block", "mdoel"], 1, "did you mean model?"),
        ([TABLE, "--write", "GRAPH", "--block", "noisy"], 1, "takes neither two exponentials"),
        ([TABLE, "--write", "GRAPH", "--block", "digitle"], 1, "did you mean digital?"),
        ([TABLE, "--write", str(library_file("template.toml"))], 1, "has no block for the coefficients"),
        (
            [str(GRAPH), "--temperature", "chamber.temperature", "--output", "noisy.output", "--write", "GRAPH"],
            1,
            "1/K",
        ),
        ([TABLE, "--start", "1e9", "1"], 1, "start nearer to zero"),
        ([TABLE, "--offset", "nan"], 1, "must be finite"),
        ([str(GRAPH)], 2, "--temperature BLOCK.PORT"),
        ([TABLE, "--set", "model.a1=2"], 2, "only for a graph"),
        ([TABLE, "--block", "model"], 2, "--block needs --write"),
        ([TABLE, "--plot", "fit.gif"], 2, "fit.gif ends in none of .svg"),
        ([TABLE, "--order", "7"], 2, "7 is not in the range"),
        ([TABLE, "--plot", "no/folder/fit.svg"], 3, "cannot write"),
    ],
)
def test_exit_codes_and_messages(
    arguments: list[str], code: int, told: str, graph: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(graph.parent)
    before = graph.read_bytes()
    assert main(["fit", *(word.replace("GRAPH", str(graph)) for word in arguments)]) == code
    assert told in capsys.readouterr().err
    assert graph.read_bytes() == before


def test_what_a_run_of_a_graph_takes(capsys: Captured) -> None:
    arguments = ["fit", str(GRAPH), *SIGNALS, "--json", "--set", "accelerometer.hysteresis=0", "--seed", "3"]
    assert main([*arguments, "--duration", "270 min", "--engine", "python"]) == 0
    read = json.loads(capsys.readouterr().out)
    assert read["rows"] == 271
    assert read["fits"][0]["peak_to_peak"] < 2e-5


@pytest.mark.exhaustive
def test_a_reader_that_goes_away_leaves_nothing_undone(graph: Path) -> None:
    command = [sys.executable, "-m", "proofmass", "fit", TABLE, "--write", str(graph)]
    read, write = os.pipe()
    os.close(read)
    subprocess.run(command, stdout=write, stderr=subprocess.DEVNULL, timeout=60, check=False)
    os.close(write)
    assert model(graph)["b1"] == pytest.approx(-5.9936064, rel=1e-6)
