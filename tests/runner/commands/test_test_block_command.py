"""`proofmass test-block`: a line for each check, every fault at once, exit codes."""

import json
from pathlib import Path

import pytest

from proofmass.runner.command_line import main
from proofmass.runner.contract.contract import RUN, STILL

FILE = '''
from proofmass import Block, Input, param


class Doubled(Block):
    """Twice the input."""

    input = Input("V", "What is doubled.")


@Doubled.output("V")
def output(p, input: float) -> float:
    """Twice the input."""
    return 2.0 * input


class Printed(Block):
    """What it prints"""

    limit: int = param("1", "", default=4)
    input = Input("V", "What is printed.")


@Printed.output("V")
def printed(p, input: float) -> float:
    """The input."""
    print(input)
    return [input][0]
'''
Captured = pytest.CaptureFixture[str]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "my blocks.py"
    path.write_text(FILE)
    return path


@pytest.mark.exhaustive
@pytest.mark.friendly(19, "a sound block passes")
def test_a_block_that_is_sound(file: Path, capsys: Captured) -> None:
    assert main(["test-block", str(file), "Doubled"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "Doubled"
    assert [line.split("  ")[1].strip() for line in lines[1:-1]] == [*STILL, *RUN]
    assert lines[-1] == "1 block passed every check that could be run"


@pytest.mark.exhaustive
@pytest.mark.friendly(19, "faults of all blocks are told at once")
def test_all_faults_of_all_blocks_at_once(file: Path, capsys: Captured) -> None:
    assert main(["test-block", str(file)]) == 1
    told = capsys.readouterr().out
    place = f"    {file}:"
    assert f"{place}17: Printed: its docstring does not begin with a sentence" in told
    assert f"{place}20: Printed.limit: it has no description" in told
    assert f"{place}27: Printed.printed: print() is not compiled" in told
    assert f"{place}28: Printed.printed: a list" in told
    assert "--engine python" in told
    assert told.splitlines()[-1] == "1 of 2 blocks failed: Printed"


def test_as_data(file: Path, capsys: Captured) -> None:
    assert main(["test-block", str(file), "Printed", "--json"]) == 1
    [report] = json.loads(capsys.readouterr().out)
    assert (report["kind"], report["passed"]) == ("Printed", False)
    status = {check["check"]: check["status"] for check in report["checks"]}
    assert status["documents"] == status["functions"] == "FAILED"
    assert status["units"] == "passed"
    problems = next(check["problems"] for check in report["checks"] if check["check"] == "functions")
    assert {problem["line"] for problem in problems} == {27, 28}
    assert all(problem["hint"] for problem in problems)


@pytest.mark.parametrize(
    ("text", "names", "message"),
    [
        (FILE, ["Doubeld", "Printd"], "there is no such block\n  hint:     did you mean Doubled?"),
        ("x = 1\n", [], "there is no block in the file\n  hint:     a block is a class"),
        ("class Broken(\n", [], "the file of blocks fails: SyntaxError"),
        ("import nothing_of_that_name\n", [], "the file of blocks fails: ModuleNotFoundError"),
        (FILE.replace('"V"', '"Volt"'), [], "Doubled.input: unknown unit 'Volt'"),
    ],
)
def test_what_cannot_be_tested(text: str, names: list[str], message: str, tmp_path: Path, capsys: Captured) -> None:
    path = tmp_path / "mine.py"
    path.write_text(text)
    assert main(["test-block", str(path), *names]) == 1
    told = capsys.readouterr().err
    assert message in told
    assert "mine.py" in told
    assert "Traceback" not in told


def test_a_file_that_is_not_there_is_wrong_usage(tmp_path: Path, capsys: Captured) -> None:
    assert main(["test-block", str(tmp_path / "none.py")]) == 2
    assert "does not exist" in capsys.readouterr().err
