"""Every example of every help runs from an empty folder, as it is written, after those above it."""

import itertools
import re
import shutil
from importlib.util import find_spec
from runpy import run_path
from typing import Any

import pytest

from proofmass import simulate
from proofmass.runner.command_line import cli
from tests.runner.commands.test_user_errors import Command, command, examples_of

__all__ = ["command"]  # the fixture

DIFFERS = 1  # the exit code of `diff` where something differs
TOOLS = {  # of what examples ask for, whether it is here
    "icarus": shutil.which("iverilog") is not None,
    "--prove": find_spec("bitwuzla") is not None and find_spec("pyosys") is not None,
    "--synth": find_spec("pyosys") is not None,
}


@pytest.fixture(autouse=True)
def _no_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    """`live` opens no browser and ends at once."""

    def nothing(*given: Any) -> None:
        pass

    monkeypatch.setattr("webbrowser.open", nothing)
    monkeypatch.setattr("proofmass.runner.commands.live_command.watch", nothing)


@pytest.mark.exhaustive(
    "allan",
    "noise",
    "response",
    "test-block",
    "tune",
    "worst",
    "fit",
    "margins",
    "montecarlo",
    "report",
    "rtl",
    "live",
    "verify",
    "prove",
    "sigma-delta",
)
@pytest.mark.parametrize("name", cli.commands)
@pytest.mark.friendly(4, "every example runs from an empty folder")
def test_the_examples_of_the_help_run(name: str, command: Command) -> None:
    examples = examples_of(cli.commands[name].help or "")
    assert name in [first for first, *_ in examples]
    for words in examples:
        missing = [word for word in words if not TOOLS.get(word, True)]
        if missing:
            pytest.skip(f"no tool for {', '.join(missing)}")
        answer = command(*words)
        assert answer.code == (DIFFERS if name == words[0] == "diff" else 0), f"{words}: {answer.err}"


@pytest.mark.parametrize("name", cli.commands)
def test_an_example_goes_on_behind_a_backslash_alone(name: str) -> None:
    """Else its second line would be a command of its own in a shell."""
    parts = re.split(r"\x08\n", cli.commands[name].help or "")[1:]
    blocks = [[line.strip() for line in part.split("\n\n")[0].strip().splitlines()] for part in parts]
    examples = [block for block in blocks if block[0].startswith("proofmass")]
    assert examples
    pairs = (pair for block in examples for pair in itertools.pairwise(block))
    assert not [after for before, after in pairs if not (before.endswith("\\") or after.startswith("proofmass"))]


@pytest.mark.friendly(4, "no example needs a clone of the repository")
def test_no_help_names_a_path_of_a_clone() -> None:
    """A clone of the repository is not what people have who read the help."""
    assert not [name for name, one in cli.commands.items() if "graphs/" in (one.help or "")]


@pytest.mark.friendly(5, "new writes the same graph in Python")
def test_the_graph_in_python_is_that_in_toml(command: Command) -> None:
    assert command("new", "sensor.py").out == "wrote sensor.py; run it with: python sensor.py\n"
    by_python, by_toml = simulate(run_path("sensor.py")["graph"]), simulate("library:template")
    assert list(by_python["adc.code"].values) == list(by_toml["adc.code"].values)
    again = command("new", "sensor.py")
    assert (again.code, "exists already" in again.err) == (2, True)
    wrong = command("new", "sensor.py", "--from", "closed_loop_gyroscope")
    assert "proofmass new sensor.toml --from closed_loop_gyroscope" in wrong.err
