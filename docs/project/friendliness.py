"""The rows of friendliness.md with their points and evidence, and measurements of what takes a second.

    python -m docs.project.friendliness [--tests]

It fails where evidence is missing or a measurement is beyond its limit. With `--tests` it runs the tests named there.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PAGE = Path(__file__).with_suffix(".md")
_PROOFMASS = (sys.executable, "-m", "proofmass")


class Row(NamedTuple):
    """A row of the table: what is wanted, its points, and what shows it."""

    name: str
    points: int
    evidence: str

    @property
    def files(self) -> list[str]:
        """Files and folders of the repository that are named."""
        return re.findall(r"`((?:tests|docs|benchmarks)/[\w./-]+)`", self.evidence)


def rows(text: str) -> Iterator[Row]:
    """Yield the rows of the table."""
    for name, points, evidence in re.findall(r"^\| (.+?) \| (\d) \| (.+?) \|$", text, re.MULTILINE):
        yield Row(name, int(points), evidence)


def _cpu(*words: str) -> tuple[float, str]:
    """Seconds of processor time of a command, and what it said."""
    before = os.times()
    done = subprocess.run([*_PROOFMASS, *words], capture_output=True, text=True, check=False)
    after = os.times()
    spent = after.children_user + after.children_system - before.children_user - before.children_system
    return spent, done.stdout + done.stderr


def _help() -> tuple[bool, str]:
    spent, _ = _cpu("--help")
    return spent <= 0.25, f"{spent:.2f} s of CPU"


def _report(folder: str) -> tuple[bool, str]:
    began = time.perf_counter()
    spent, _ = _cpu("run", "library:closed_loop_accelerometer", "--quiet", "--out", folder)
    written = (Path(folder) / "report.html").is_file()
    return written and time.perf_counter() - began < 10.0, f"{spent:.1f} s of CPU"


def _new(folder: str) -> tuple[bool, str]:
    _, said = _cpu("new", f"{folder}/sensor.toml")
    files = sorted(path.name for path in Path(folder).glob("*.*") if path.suffix in (".toml", ".json"))
    return "proofmass-graph.json" in files, said.strip().replace(folder, "")


def _profile() -> tuple[bool, str]:
    _, said = _cpu("run", "library:template", "--profile", "--quiet")
    found = re.search(r"each part alone.*", said)
    return found is not None, found[0] if found else said


MEASURED: dict[str, Callable[[str], tuple[bool, str]]] = {
    "help in 0.2 s, each command with an example": lambda folder: _help(),
    "a report in 10 s, cold": _report,
    "`new` writes a commented graph that runs": _new,
    "a profile of a run": lambda folder: _profile(),
}


def main(words: list[str]) -> int:
    """Print the table; return 0 if all evidence is there and all measurements are within their limits."""
    table, wrong = list(rows(PAGE.read_text(encoding="utf-8"))), 0
    for row in table:
        missing = [file for file in row.files if not (ROOT / file).exists()]
        line = f"{row.points}  {row.name}: {row.evidence}"
        if row.name in MEASURED:
            with tempfile.TemporaryDirectory() as folder:
                good, said = MEASURED[row.name](folder)
            line += f"\n   now: {said}" + ("" if good else "  BEYOND ITS LIMIT")
            wrong += not good
        if missing:
            line += f"\n   MISSING: {', '.join(missing)}"
            wrong += 1
        print(line)
    print(f"{sum(row.points for row in table)} of {2 * len(table)}")
    if "--tests" in words:
        tests = sorted({file for row in table for file in row.files if file.startswith("tests/")})
        wrong += subprocess.run([sys.executable, "-m", "pytest", "-q", *tests], cwd=ROOT, check=False).returncode
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
