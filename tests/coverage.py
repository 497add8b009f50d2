"""Which branches of the source some test takes: a table by room, and those that none takes and nobody explains.

    python -m tests.coverage --exhaustive               every test
    python -m tests.coverage                            every test that is not exhaustive
    python -m tests.coverage tests/blocks tests/graphs  some of them
    python -m tests.coverage tests/runner/plan --more   these too, beside what was measured before
    python -m tests.coverage --again                    the table of the last run once more
    python -m tests.coverage --by-test                  instead, which tests pass which line: for tests/mutants.py

Functions of blocks count where plain Python calls them: machine code is made of the same lines, but does not pass them.
Processes that tests start are measured too. In `EXPLAINED` all is taken but what `branches_that_stay.toml` gives a
reason for. By test, lines are measured without their branches, which would be a hundred million rows: `Passing` reads
them.
"""

import argparse
import ast
import json
import os
import resource
import subprocess
import sys
import time
import tomllib
from collections import Counter, defaultdict
from collections.abc import Generator, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import coverage
import pytest
from coverage.parser import PythonParser

ROOT = Path(__file__).parents[1]
DATA = ROOT / "build" / "coverage"
LINES = DATA / "lines"  # which tests pass them
SECONDS = DATA / "seconds.json"  # of each test
STAY = Path(__file__).with_name("branches_that_stay.toml")
SOURCE = ("blocks", "graphs", "runner")
EXPLAINED = ("blocks", "graphs", "runner/plan", "runner/program", "runner/run")


class Branch(NamedTuple):
    """A branch, or a line that no branch leads to, that is not taken."""

    file: str
    line: int
    to: int  # line; below 0 the end of a function; the line itself where it is not run at all

    def text(self) -> str:
        """The line that it begins at."""
        return (ROOT / self.file).read_text(encoding="utf-8").splitlines()[self.line - 1].strip()

    def told(self) -> str:
        """The place, the line, and where it leads to."""
        way = "is not run" if self.to == self.line else f"never to {self.to}" if self.to > 0 else "never to the end"
        return f"{self.file}:{self.line}: {way}: {self.text()}"


class Room(NamedTuple):
    """How much of a folder is covered."""

    lines: int = 0
    run: int = 0
    branches: int = 0
    taken: int = 0


# -- measuring: as a plugin of pytest (-p tests.coverage) --------------------------------------------------------------


def _is_by_test() -> bool:
    return os.environ.get("COVERAGE_FILE") == str(LINES)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Note the test that the lines run for, and when it begins."""
    item.stash[_BEGUN] = _processor_seconds()
    running = coverage.Coverage.current()
    if running is not None and _is_by_test():
        running.switch_context(item.nodeid)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Take processor time for the length of a test: the clock says how busy the machine is."""
    report, now = (yield), _processor_seconds()
    report.duration, item.stash[_BEGUN] = now - item.stash.get(_BEGUN, now), now
    return report


def _processor_seconds() -> float:
    return time.process_time() + sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


_BEGUN = pytest.StashKey[float]()
_seconds = Counter[str]()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Add up the time of each test."""
    _seconds[report.nodeid] += report.duration


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Save what a process of xdist has measured, which is not always asked to end by itself."""
    if not hasattr(session.config, "workerinput"):
        if not _is_by_test():
            return
        SECONDS.parent.mkdir(parents=True, exist_ok=True)
        before = json.loads(SECONDS.read_text(encoding="utf-8")) if SECONDS.exists() else {}
        SECONDS.write_text(json.dumps(before | _seconds), encoding="utf-8")
        return
    running = coverage.Coverage.current()
    if running is not None:
        running.stop()
        running.save()


# -- what was measured ------------------------------------------------------------------------------------------------


def measured(data: Path = DATA / "data") -> coverage.Coverage:
    """Return what the last run has measured."""
    found = coverage.Coverage(data_file=str(data), config_file=str(ROOT / "pyproject.toml"))
    found.load()
    return found


def missing(found: coverage.Coverage) -> tuple[list[Branch], Mapping[str, Room]]:
    """Return the branches that no test takes, and the counts by room."""
    left, rooms = list[Branch](), defaultdict[str, Room](Room)
    for path in sorted(path for room in SOURCE for path in (ROOT / room).rglob("*.py")):
        file = str(path.relative_to(ROOT))
        analysis = found._analyze(str(path))  # what the public calls are made of; each would read the file again
        lines, not_run, numbers = analysis.statements, sorted(analysis.missing), analysis.numbers
        arcs = _without_ends_of_matches(analysis.missing_branch_arcs() if numbers.n_branches else {}, path)
        left += [Branch(file, line, to) for line, ends in arcs.items() if line not in not_run for to in ends]
        led = {to for ends in arcs.values() for to in ends}
        left += [Branch(file, line, line) for line in not_run if line not in led and not _follows(line, not_run)]
        before = rooms[_room(file)]
        taken = numbers.n_branches - numbers.n_missing_branches
        more = len(lines), len(lines) - len(not_run), numbers.n_branches, taken
        rooms[_room(file)] = Room(*(a + b for a, b in zip(before, more, strict=True)))
    return left, rooms


def _without_ends_of_matches(arcs: Mapping[int, Sequence[int]], path: Path) -> dict[int, list[int]]:
    """Leave out the ways past the last case of a `match`: where it is to take everything, mypy says that it does."""
    last = dict[int, range]()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Match):
            case = node.cases[-1]
            last[case.pattern.lineno] = range(case.body[0].lineno, (case.body[-1].end_lineno or 0) + 1)
    return {
        line: left for line, ends in arcs.items() if (left := [n for n in ends if line not in last or n in last[line]])
    }


def _follows(line: int, not_run: Sequence[int]) -> bool:
    """Return whether the line before is not run either: one of a piece of code stands for it."""
    return line - 1 in not_run


def _room(file: str) -> str:
    first, second, *_ = file.split("/")
    return first if first == "blocks" or second.endswith(".py") else f"{first}/{second}"


class Passing:
    """Which tests pass a line, and how long each takes."""

    def __init__(self) -> None:
        self._data = measured(LINES).get_data()
        self._seconds: Mapping[str, float] = json.loads(SECONDS.read_text(encoding="utf-8"))
        self._lines = dict[str, Mapping[int, set[str]]]()
        self._every = dict[str, set[str]]()

    def of(self, file: str, line: int) -> dict[str, float]:
        """Return the seconds of each test that passes a line, the quickest first.

        Of a line that runs at import these are all that pass any line of its file: the first one alone imports it.
        """
        if file not in self._lines:
            parser = PythonParser(filename=str(ROOT / file))
            parser.parse_source()
            by_line = self._data.contexts_by_lineno(str(ROOT / file))
            self._lines[file] = {n: set(by_line.get(parser.first_line(n), ())) for n in _of_functions(ROOT / file)}
            self._every[file] = set().union(*by_line.values())
        tests = self._lines[file].get(line, set()) - {""} or self._every[file] - {""}
        return dict(sorted(((test, self._seconds.get(test, 1.0)) for test in tests), key=lambda item: item[1]))


def _of_functions(path: Path) -> Iterator[int]:
    """Yield the lines of a file that run when a function is called."""
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from range(node.body[0].lineno, (node.end_lineno or 0) + 1)


def reasons() -> Mapping[tuple[str, str], str]:
    """Return why branches may stay untaken, by file and line."""
    rows = tomllib.loads(STAY.read_text(encoding="utf-8")).get("branch", []) if STAY.exists() else []
    return {(row["file"], row["line"]): row["reason"] for row in rows}


def table(rooms: Mapping[str, Room]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield f"{'room':24} {'lines':>7} {'run':>8} {'branches':>9} {'taken':>8}"
    everything = Room(*(sum(counts) for counts in zip(*rooms.values(), strict=True)))
    for name, room in (*sorted(rooms.items()), ("all", everything)):
        yield f"{name:24} {room.lines:7} {_share(room.run, room.lines)} {room.branches:9} " + _share(
            room.taken, room.branches
        )


def _share(part: int, whole: int) -> str:
    return f"{100.0 * part / whole if whole else 100.0:6.2f} %"


# -- the command ------------------------------------------------------------------------------------------------------


def run(words: Sequence[str], workers: int, more: bool = False, by_test: bool = False) -> int:
    """Run pytest with some words, and measure, `more` beside what was measured before; returns its exit code."""
    DATA.mkdir(parents=True, exist_ok=True)
    data = LINES if by_test else DATA / "data"
    for old in () if more else (*([SECONDS] if by_test else []), *DATA.glob(f"{data.name}*")):
        old.unlink(missing_ok=True)
    environment = {**os.environ, "COVERAGE_FILE": str(data)}
    options = ["--numprocesses", str(workers), "--dist", "worksteal", "-p", "tests.coverage"]
    what = [] if by_test else ["--branch"]
    command = [sys.executable, "-m", "coverage", "run", *what, "-m", "pytest", *options, *words]
    code = subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode
    combine = ["combine", "--quiet", *(["--append"] if more else [])]
    subprocess.run([sys.executable, "-m", "coverage", *combine], cwd=ROOT, env=environment, check=True)
    return code


def main() -> int:
    """Measure, print the table and what no test takes, and return 1 if something of that has no reason."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("tests", nargs="*", help="files or folders of tests (default: all)")
    parser.add_argument("--exhaustive", action="store_true", help="the exhaustive tests too")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--more", action="store_true", help="keep what was measured before")
    parser.add_argument("--by-test", action="store_true", help="measure which tests pass a line, and print no table")
    parser.add_argument("--again", action="store_true", help="take what the last run has measured")
    arguments = parser.parse_args()
    words = [*arguments.tests, *(["--exhaustive"] if arguments.exhaustive else [])]
    code = 0 if arguments.again else run(words, arguments.workers, arguments.more, arguments.by_test)
    if arguments.by_test:
        return code
    left, rooms = missing(measured())
    known, unexplained = reasons(), Counter[str]()
    for branch in left:
        if not branch.file.startswith(tuple(f"{room}/" for room in EXPLAINED)):
            continue
        if (branch.file, branch.text()) not in known:
            unexplained[_room(branch.file)] += 1
            print(branch.told())
    print(*table(rooms), sep="\n")
    print(f"without a reason: {dict(unexplained)}" if unexplained else "all else has its reason")
    return code or int(bool(unexplained))


if __name__ == "__main__":
    sys.exit(main())
