"""Options that say something of a name: two that say it of one are refused, not the last taken."""

from pathlib import Path

import click
import pytest

from proofmass.runner.command_line import main
from proofmass.runner.commands.named_options import by_name

FREE = ["--free", "sensor.damping"]
DATA = ["--data", "record.csv", "--input", "push.output=a", "--output", "sensor.displacement=b", *FREE]


def test_names_that_are_said_once() -> None:
    assert by_name("--free", iter([("b", 2), ("a", 1)])) == {"b": 2, "a": 1}
    with pytest.raises(click.UsageError, match=r"--free a is given twice: keep one of them"):
        by_name("--free", [("a", 1), ("b", 2), ("a", 1)])
    with pytest.raises(click.UsageError, match=r"--slow-change is given twice"):
        by_name("--slow-change", [("", "1 %/s"), ("", "2 %/s")])


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["fit", *DATA, "--output", "sensor.displacement=a"], "--output sensor.displacement"),
        (["fit", *DATA, "--input", "push.output=b"], "--input push.output"),
        (["fit", *DATA, "--free", "sensor.damping=1e-3..2e-3"], "--free sensor.damping"),
        (["prove", "--peak", "adc.number=3", "--peak", "adc.number=2"], "--peak adc.number"),
        (
            ["prove", "--tolerance", "adc.reference=1 %", "--tolerance", "adc.reference=2 %"],
            "--tolerance adc.reference",
        ),
        (
            ["worst", "--tolerance", "adc.reference=1 %", "--tolerance", "adc.reference=2 %"],
            "--tolerance adc.reference",
        ),
        (["margins", "--gain", "adc=1", "--gain", "adc=2"], "--gain adc"),
    ],
)
@pytest.mark.defect("H878", before="of two options about one name the last counted, without a word", after="refused")
def test_a_name_is_said_once(
    arguments: list[str], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("record.csv").write_text("time,a,b\n0,1,2\n")
    command, *options = arguments
    assert main([command, "library:template", *options]) == 2
    assert f"{told} is given twice: keep one of them" in capsys.readouterr().err
