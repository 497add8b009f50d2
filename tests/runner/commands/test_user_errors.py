"""What a user types wrong ends in a message and the right exit code; what the help shows is right."""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.graphs.files.library import library_file
from proofmass.runner.command_line import main
from tests.by_hand.graph_texts import ALONE

TEMPLATE = str(library_file("template.toml"))
CLOSED_LOOP = str(library_file("closed_loop_accelerometer.toml"))
UNSTABLE = """name = "unstable"
rate = "1 kHz"
samples = 1000
wires = ["gain.output -> delay.input", "delay.output -> gain.input"]
probes = ["gain.output"]
[blocks.delay]
kind = "UnitDelay"
initial = 1.0
[blocks.gain]
kind = "Gain"
gain = 1e30
"""
OWN = """from typing import Any
from proofmass import Block, Input, param

class Offset(Block):
    \"\"\"Adds an offset.\"\"\"
    offset: float = param("V", "What is added.", default=1.0)
    input = Input("V", "Input.")

@Offset.output("V")
def output(p: Any, input: float) -> float:
    \"\"\"The sum.\"\"\"
    return input + p.offset
"""


class Answer(NamedTuple):
    """What a command left behind."""

    code: int
    out: str
    err: str


class Command:
    """Calls the command in this process; no answer may hold a traceback or codes for a terminal."""

    def __init__(self, captured: pytest.CaptureFixture[str]) -> None:
        self._captured = captured

    def __call__(self, *arguments: str) -> Answer:
        code = main(list(arguments))
        out, err = self._captured.readouterr()
        assert not re.search(r"Traceback|\x1b|\r", out + err)
        return Answer(code, out, err)


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Command:
    """The command, called in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return Command(capsys)


def ran(folder: Path, *arguments: str) -> Answer:
    """The command in a process of its own."""
    words = [sys.executable, "-m", "proofmass", *arguments]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, encoding="utf-8", check=False)
    return Answer(done.returncode, done.stdout, done.stderr)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["rnu"], "no such command: rnu; did you mean run?"),
        (["run"], "Missing argument 'GRAPH'"),
        (["run", TEMPLATE, "--sampels", "3"], "--samples"),
        (["run", TEMPLATE, "--samples", "0"], "--samples"),
        (["run", TEMPLATE, "--samples", "3", "--duration", "1 s"], "give --duration or --samples, not both"),
        (["run", TEMPLATE, "--seed", "-1"], "--seed"),
        (["run", TEMPLATE, "--engine", "fast"], "'fast' is not one of"),
        (["run", TEMPLATE, "--resume"], "--resume needs --out"),
        (["run", TEMPLATE, "--format", "csv"], "--format needs --out"),
        (["run", TEMPLATE, "--set", "bits=12"], "write BLOCK.PARAMETER=VALUE"),
        (["run", TEMPLATE, "--probe", "adc"], "write BLOCK.PORT"),
        (["allan", TEMPLATE, "--probe", "adc"], "write BLOCK.PORT"),
        (["run", "."], "is a folder"),
        (["check", TEMPLATE, "--blocks", "missing.py"], "does not exist"),
        (["draw", TEMPLATE, "--format", "png"], "'png' is not one of"),
        (["new", TEMPLATE], "exists already; nothing was written"),
    ],
)
@pytest.mark.friendly(10, "wrong usage ends with 2")
def test_wrong_usage_exits_with_2(arguments: list[str], message: str, command: Command) -> None:
    answer = command(*arguments)
    assert answer.code == 2
    assert message in answer.err
    assert not answer.out


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("adx.bits=8", "did you mean adc?"),
        ("adc.bist=8", "did you mean bits?"),
        ("adc.bits=64", "adc.bits: must be >= 2 and <= 32"),
        ("adc.bits=8.5", "adc.bits: must be an integer"),
        ("adc.reference=5 m", "adc.reference: "),
        ("adc.reference=nan", "adc.reference: "),
        ("adc.reference=" + "[" * 5000, "adc.reference: "),
        ("sensor.mass=", "sensor.mass: "),
    ],
)
@pytest.mark.friendly(14, "what cannot be is refused by its own name")
def test_set_to_what_cannot_be(change: str, message: str, command: Command) -> None:
    answer = command("run", TEMPLATE, "--samples", "3", "--set", change)
    assert answer.code == 1
    assert message in answer.err
    assert answer.err.endswith("1 problem\n")


def test_set_of_what_a_wire_drives(command: Command) -> None:
    answer = command("run", CLOSED_LOOP, "--samples", "3", "--set", "dac.reference=3 V")
    assert answer.code == 1
    assert "dac.reference: is driven by reference.output: a value would change nothing" in answer.err


def test_probe_of_what_is_probed_already_and_of_what_is_not_there(command: Command) -> None:
    assert command("run", TEMPLATE, "--samples", "3", "--probe", "adc.code").code == 0
    answer = command("run", TEMPLATE, "--samples", "3", "--probe", "adc.cod")
    assert answer.code == 1
    assert "adc.cod" in answer.err


@pytest.mark.parametrize("duration", ["soon", "1 m", "-1 s", "", "1e30 s", "1e12 s"])
def test_a_wrong_duration(duration: str, command: Command) -> None:
    answer = command("run", TEMPLATE, "--duration", duration)
    assert answer.code == 1
    assert "duration: " in answer.err


@pytest.mark.parametrize("engine", ["python", "compiled"])
@pytest.mark.friendly(10, "a run that fails ends with 3")
def test_a_failed_run_exits_with_3(engine: str, command: Command) -> None:
    Path("unstable.toml").write_text(UNSTABLE)
    answer = command("run", "unstable.toml", "--engine", engine)
    assert answer.code == 3
    told = "the run failed\nunstable.toml:9: gain.output: is not finite in tick 10, t = 0.01 s\n  got:      inf\n"
    assert answer.err.startswith(told)
    assert answer.err.endswith("more: proofmass explain P1003\n")


@pytest.mark.parametrize("text", ["", "name = 3", "\0", "[", "a" * 2_000_000], ids=range(5))
def test_no_graph_at_all(text: str, command: Command) -> None:
    Path("no.toml").write_text(text)
    for name, file in (("check", "no.toml"), ("run", "no.toml"), ("check", "missing.toml"), ("draw", "missing.toml")):
        answer = command(name, file)
        assert answer.code == 1
        assert file in answer.err


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("x = 1\nclass :\n", 2, "SyntaxError"),
        ("import proofmass\n\n1 / 0\n", 3, "ZeroDivisionError: division by zero"),
        ("import no_such_module_anywhere\n", 1, "ModuleNotFoundError: No module named"),
        (OWN.replace("param(", "parma("), 6, "name 'parma' is not defined"),
        (OWN.replace("p: Any, input", "p: Any, inptu"), 9, "cannot bind the argument"),
    ],
    ids=["syntax", "run", "import", "name", "argument"],
)
def test_a_file_of_blocks_that_fails(text: str, line: int, message: str, command: Command) -> None:
    Path("bad.py").write_text(text)
    answer = command("check", TEMPLATE, "--blocks", "bad.py")
    assert answer.code == 1
    assert f"bad.py:{line}: the file of blocks fails: " in answer.err
    assert message in answer.err


@pytest.mark.exhaustive
def test_the_traceback_is_shown_wherever_it_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "unstable.toml").write_text(UNSTABLE)
    for arguments in (["--traceback", "run", "unstable.toml"], ["run", "unstable.toml", "--traceback"]):
        answer = ran(tmp_path, *arguments)
        assert "Traceback (most recent call last)" in answer.err
        assert "RunError: unstable.toml:9: gain.output" in answer.err
        assert answer.code != 0


def test_an_error_of_our_own_is_a_message_too(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(request: Any) -> int:
        raise KeyError("something")

    monkeypatch.setattr("proofmass.runner.commands.run_command.run_graph", broken)
    answer = command("run", TEMPLATE)
    assert answer.code == 3
    assert "an error inside proofmass: KeyError: 'something'" in answer.err
    assert "--traceback shows where" in answer.err


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["Größe 加速度.toml", "-x.toml"])
@pytest.mark.friendly(41, "files with spaces and any letters")
def test_names_of_files_with_spaces_and_letters_of_any_kind(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "Ordner für alles"
    folder.mkdir()
    (folder / name).write_bytes(Path(TEMPLATE).read_bytes())
    answer = ran(folder, "run", "--samples", "5", "--format", "csv", "--out", f"out {name}", "--", name)
    assert answer.code == 0, answer.err
    assert (folder / f"out {name}" / "traces.csv").exists()


@pytest.mark.exhaustive
@pytest.mark.parametrize("arguments", [["blocks"], ["run", TEMPLATE, "--show-source"]], ids=["blocks", "source"])
def test_a_reader_that_goes_away_is_no_error(arguments: list[str]) -> None:
    words = [sys.executable, "-m", "proofmass", *arguments]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


def examples_of(text: str) -> list[list[str]]:
    """The words of each example, as a shell takes them: of several lines, up to a second command or a redirection."""
    commands = re.findall(r"^ *proofmass (.*)$", text.replace("\\\n", " "), re.MULTILINE)
    return [shlex.split(re.split(r"&&|>", command)[0]) for command in commands]


def test_an_example_is_read_as_a_shell_reads_it() -> None:
    text = 'Text.\n\n  proofmass a --b "c d" > e\n  proofmass f \\\n      --g && proofmass h\n'
    assert examples_of(text) == [["a", "--b", "c d"], ["f", "--g"]]


@pytest.mark.exhaustive(but=12)
@pytest.mark.parametrize("path", ALONE, ids=lambda path: path.stem)
def test_the_source_of_every_example_is_one_loop_and_what_it_calls(path: Path, command: Command) -> None:
    lines = [line.partition("  # ")[0].rstrip() for line in command("run", str(path), "--show-source").out.splitlines()]
    defined = [match[1] for line in lines if (match := re.match(r"(?:inline )?def (\w+)\(", line))]
    assert defined.pop() == "loop"
    assert len(defined) == len(set(defined))
    statements = [line for line in lines if not re.match(r"(inline )?def ", line)]
    called = {name for line in statements for name in re.findall(r"(\w+)\(", line)}
    assert set(defined) <= called
    call = re.compile(rf"\s*(?:[\w, ]+ :?= )?(?:{'|'.join(defined)})\(.*\)")  # arguments: one for each number
    lengths = [len(line) for line in statements if not call.fullmatch(line)]
    assert max(lengths) < 700  # of a table in a digital block


@pytest.mark.exhaustive
def test_what_is_shown_of_a_block_is_a_piece_of_a_graph_file(command: Command) -> None:
    for kind in all_blocks():
        shown = command("blocks", kind).out
        assert shown.startswith(f"{kind}: ")
        assert tomllib.loads(shown.partition("In a graph file:")[2])["blocks"]["name"]["kind"] == kind


@pytest.mark.exhaustive
@pytest.mark.friendly(23, "a bar on a terminal leaves no trace")
def test_a_terminal_has_a_progress_bar_that_leaves_no_trace(tmp_path: Path) -> None:
    pty = pytest.importorskip("pty")
    path = tmp_path / "long.toml"
    path.write_text(UNSTABLE.replace("1e30", "0.5").replace("samples = 1000", "samples = 300_000"))
    words = [sys.executable, "-m", "proofmass", "run", str(path), "--engine", "python"]
    here, there = pty.openpty()
    seen = b""
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=there) as process:
        os.close(there)
        try:
            while piece := os.read(here, 1024):
                seen += piece
        except OSError:  # the other end was closed
            pass
    os.close(here)
    assert process.returncode == 0
    assert b"of 300,000 ticks" in seen
    assert seen.endswith(b"\r\x1b[J")
