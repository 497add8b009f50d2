"""What a terminal gets: tables as wide as it is, and colour where it has it."""

import click
import pytest

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.commands.answers import print_problem
from proofmass.runner.output.text_table import text_table


@pytest.mark.friendly(42, "tables fold at the width of the terminal")
def test_a_table_is_as_wide_as_the_terminal_and_nothing_is_lost() -> None:
    rows = [("signal", "mean", "std", ""), ("adc.code", "12.5", "0.25", "the code that comes out of it")]
    assert text_table(rows, left=(0, 3), width=0) == text_table(rows, left=(0, 3), width=80)
    broken = text_table(rows, left=(0, 3), width=46)
    assert broken == ["signal    mean   std", "adc.code  12.5  0.25  the code that comes out", " " * 22 + "of it"]
    narrow = text_table(rows, left=(0, 3), width=38)
    assert all(len(line) <= 38 for line in narrow)
    assert narrow[3:5] == ["signal", "adc.code  the code that comes out of"]


@pytest.mark.parametrize(("settings", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)])
@pytest.mark.friendly(42, "colour only where the terminal has it")
def test_colour_only_where_the_terminal_has_it(
    settings: dict[str, str], coloured: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("NO_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    written: list[str] = []
    monkeypatch.setattr(click, "echo", lambda text, err: written.append(text))  # a terminal takes everything
    print_problem(Problem(message="unknown key", hint="did you mean rate?"))
    assert ("\x1b[" in written[0]) == coloured
    monkeypatch.undo()
    print_problem(Problem(message="unknown key", hint="did you mean rate?"))
    assert capsys.readouterr().err == "unknown key\n  hint:     did you mean rate?\n"  # a pipe has no colour
