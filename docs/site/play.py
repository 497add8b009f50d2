"""A page played as its reader would: its files written, its commands run, in the order of the page."""

import contextlib
import io
import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from proofmass.runner.command_line import main

_FENCE = re.compile(r"^```(\w+)\n(.*?)^```$(?=(\n\n^```text\n(.*?)^```$)?)", re.DOTALL | re.MULTILINE)
_FILE = re.compile(r"# (at the end of )?([\w-]+\.(?:toml|py|csv))\n")
_DATA = re.compile(r"^```text\n((?:(?!^```).)*)^```\n\nSave it as `([\w.-]+)`", re.DOTALL | re.MULTILINE)
_REJECTED = "# exit code 1"
Run = Callable[[list[str]], tuple[int, str]]


class Command(NamedTuple):
    """A command of a page: what it answered and what the page promises."""

    text: str
    status: int
    expected_status: int
    output: str
    promised: str


def play(page: Path, run: Run | None = None) -> Iterator[Command]:
    """Write the files of a page to the working folder and yield its commands as they are run.

    `run` takes the words after `proofmass` and returns exit code and output; by default they run in this process.
    """
    whole = page.read_text(encoding="utf-8")
    for text, name in _DATA.findall(whole):
        Path(name).write_text(text, encoding="utf-8")
    for language, text, _, answer in _FENCE.findall(whole):
        file = _FILE.match(text)
        if file:
            with Path(file[2]).open("a" if file[1] else "w", encoding="utf-8") as stream:
                stream.write(("\n" if file[1] else "") + text)
        elif language == "sh":
            yield from _commands(text.replace("\\\n", " ").splitlines(), answer, run or run_here)


def _commands(lines: list[str], promised: str, run: Run) -> Iterator[Command]:
    """Yield the commands of one fence; the answer below it is that of all of them together."""
    outputs = []
    for line in lines:
        program, *words = shlex.split(line, comments=True)
        assert program == "proofmass", line
        status, output = run(words)
        outputs.append(output)
        last = len(outputs) == len(lines)
        yield Command(line, status, int(_REJECTED in line), "".join(outputs), promised if last else "")


def run_here(words: list[str]) -> tuple[int, str]:
    """Run a command of proofmass in this process; return exit code and output."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        status = main(words)
    return status, text.getvalue()


def missing_lines(output: str, promised: str) -> list[str]:
    """Return the promised lines that the output lacks; numbers agree within a twentieth."""
    lines = iter([line.split() for line in output.splitlines()])
    return [line for line in promised.splitlines() if line.strip() and not any(_same(line.split(), x) for x in lines)]


def _same(promised: list[str], printed: list[str]) -> bool:
    return len(promised) == len(printed) and all(map(_same_word, promised, printed))


def _same_word(promised: str, printed: str) -> bool:
    numbers = [re.sub(r"\(\d+\)$", "", word).replace(",", "") for word in (promised, printed)]
    try:
        first, second = map(float, numbers)
    except ValueError:
        return promised == printed
    return abs(first - second) <= 0.05 * abs(first)
