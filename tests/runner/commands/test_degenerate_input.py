"""Commands on input without an answer: a sentence each, no number that looks right, no warning, no error inside."""

import json
import random
from pathlib import Path

import pytest

from proofmass.runner.command_line import main

GRAPH = """\
name = "a low-pass"
rate = "1 kHz"
duration = "0.2 s"
wires = ["source.output -> low.input"]
probes = ["low.output"]

[measures]
mean = { signal = "low.output", statistic = "mean" }
settles = { signal = "low.output", statistic = "settling_time", target = 5.0, within = 0.1 }

[requirements]
mean = { quantity = "mean", at_least = "0.5 V" }
settles = { quantity = "settles", at_most = "1 s" }

[blocks]
source = { kind = "Constant", value = 1, unit = "V" }

[blocks.low]
kind = "LowPass"
corner_frequency = "20 Hz"
input_unit = "V"
output_unit = "V"

[tune]
samples = 2
starts = 1
free = { "low.gain" = { at_least = 0.5, at_most = 2.0 } }
goals = { settles = { measure = "settles", at_most = "1 s" } }
"""
DICE = random.Random(3)
SIGNALS = {
    "constant": [1.0] * 200,
    "zero": [0.0] * 200,
    "empty": [],
    "one": [1.0],
    "two": [1.0, 2.0],
    "large": [1e300 * DICE.gauss(0.0, 1.0) for _ in range(200)],
    "small": [1e-300 * DICE.gauss(0.0, 1.0) for _ in range(200)],
    "smallest": [DICE.choice((0.0, 5e-324)) for _ in range(200)],
    "nan": [float("nan")] * 200,
}
FIT = ("fit", "graph.toml", "--data", "{}", "--output", "low.output=volts", "--free", "low.gain", "--json")
COMMANDS = {
    "allan": ("allan", "{}", "--json"),
    "spectrum": ("spectrum", "{}", "--json"),
    "fit": FIT,
    "law": ("fit", "{}", "--json"),
}
TRUE = {  # what has an answer: no noise, a gain of zero, the gain that has the least squares
    ("spectrum", "constant"), ("spectrum", "zero"), ("fit", "zero"), ("fit", "constant")
}  # fmt: skip


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "graph.toml").write_text(GRAPH)
    return tmp_path


@pytest.mark.defect(
    "S661",
    before="fit --data of values of 1e-300 converged, with warnings of NumPy; others ended in an error inside",
    after="refused by their size, as in spectrum",
)
@pytest.mark.parametrize("signal", SIGNALS)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_sentence_or_what_is_true(command: str, signal: str, capsys: pytest.CaptureFixture[str]) -> None:
    head = "temperature [K],output [V]" if command == "law" else "time [s],volts [V]"
    rows = [f"{0.001 * number!r},{value!r}" for number, value in enumerate(SIGNALS[signal])]
    Path("record.csv").write_text("\n".join([head, *rows]) + "\n")
    code = main([part.format("record.csv") for part in COMMANDS[command]])
    shown = capsys.readouterr()
    assert "error inside" not in shown.err
    if (command, signal) in TRUE:
        answer = json.loads(shown.out)
        if command == "fit":
            (gain,) = answer["parameters"].values()
            assert gain["value"] == pytest.approx(1.0 if signal == "constant" else 0.0, abs=0.05)
        else:
            assert answer["rms"] == 0.0
        return
    assert code != 0
    assert "record.csv" in shown.err or "volts" in shown.err or "output" in shown.err
    assert not shown.out.strip() or json.loads(shown.out)["problems"]


@pytest.mark.exhaustive
def test_goals_worst_cases_and_requirements_without_a_value(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "graph.toml"]) == 1
    assert "no value" in capsys.readouterr().out
    assert main(["tune", "graph.toml"]) == 1
    shown = capsys.readouterr().out
    assert "without: settles" in shown
    assert "undefined s" not in shown
    main(["worst", "graph.toml", "--measure", "settles", "--tolerance", "low.gain=5 %", "--samples", "2"])
    shown = capsys.readouterr().out
    assert "no value nominal, no value at worst" in shown
    assert "unstable" not in shown
