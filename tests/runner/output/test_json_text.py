"""JSON of measures that have no value: null, as JSON has it, and "undefined" in tables."""

import json
from pathlib import Path
from typing import Any

import pytest

from proofmass.runner.command_line import main
from proofmass.runner.output.json_text import json_text

MODEL = """\
name = "settles or not"
rate = "1 kHz"
duration = "30 ms"
[measures]
settled = { signal = "level.output", statistic = "settling_time", target = 0, within = 1 }
[blocks]
level = { kind = "Constant", value = 1 }
"""


def refuse(name: str) -> Any:
    raise ValueError(f"{name} is not JSON")


@pytest.mark.defect("C440", before="--json of a sweep has NaN, which JSON readers refuse; its table nan", after="null")
def test_a_sweep_with_a_measure_without_a_value(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "model.toml"
    path.write_text(MODEL)
    command = ["run", str(path), "--sweep", "level.value=1,2"]
    assert main(command) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split() for row in rows[-2:]] == [["1", "0"], ["2", "undefined"]]
    assert main([*command, "--json"]) == 0
    data = json.loads(capsys.readouterr().out, parse_constant=refuse)
    assert [point["settled"] for point in data["points"]] == [0.0, None]


def test_numbers_deep_within() -> None:
    data = {"a": [1.5, float("inf"), {"b": (float("nan"), 2, True, "text", None)}]}
    assert json.loads(json_text(data)) == {"a": [1.5, None, {"b": [None, 2, True, "text", None]}]}
