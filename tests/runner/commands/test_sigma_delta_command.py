"""`sigma-delta` as the shell sees it."""

import json
from pathlib import Path

import numpy as np
import pytest

from proofmass import read_graph, simulate
from proofmass.runner.command_line import main

Captured = pytest.CaptureFixture[str]


@pytest.mark.exhaustive
def test_a_loop_is_designed_written_and_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured) -> None:
    """The ratio of a run of the written graph, by sums over whole periods, is the one that the table has at -6 dB."""
    monkeypatch.chdir(tmp_path)
    words = ["sigma-delta", "--order", "2", "--oversampling", "64", "--form", "ciff", "--rate", "2 MHz"]
    assert main([*words, "--out", "loop.toml", "--plot", "loop.png"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("CIFF of order 2, 2 levels, discrete time\n")
    assert "wrote loop.toml\nwrote loop.png\n" in shown
    assert Path("loop.png").read_bytes().startswith(b"\x89PNG")
    ratio = next(float(line.split()[2]) for line in shown.splitlines() if line.split()[:1] == ["-6"])
    graph = read_graph("loop.toml")
    assert graph.rate == 2_000_000
    bits = np.asarray(simulate(graph)["quantiser.sign"].values)
    lines = np.abs(np.fft.rfft(bits * np.hanning(len(bits)))) ** 2
    tone = slice(100, 107)
    noise = lines[4 : len(bits) // 128].sum() - lines[tone].sum()
    assert 10.0 * np.log10(lines[tone].sum() / noise) == pytest.approx(ratio, abs=3.0)


def test_plain_data_and_mistakes(capsys: Captured) -> None:
    assert main(["sigma-delta", "--order", "3", "--pulse", "0", "1", "--swing", "0", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["pulse"] == [0.0, 1.0]
    assert data["coefficients"]["c"] == [1.0, 1.0, 1.0]
    assert len(data["predicted"]) == len(data["simulated"]) == len(data["amplitudes"])
    assert main(["sigma-delta", "--gain", "20"]) == 1
    assert "gain: must be a gain that this order has" in capsys.readouterr().err
    assert main(["sigma-delta", "--rate", "2 MV"]) == 2
    assert "--rate 2 MV" in capsys.readouterr().err
