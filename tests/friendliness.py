"""The list of `make friendliness`: what a person does with this package and expects of it, and the tests that show it.

A test takes part by its marker: `@pytest.mark.friendly(6, "nine faults of one file, each with its line")`. A row scores
2 if all its tests pass, 0 if it has none or none of them passes, and 1 otherwise: a test that is skipped shows nothing.
"""

import ast
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.marked import MarkedTable, Row

EXPECTED = {
    1: "installs it into an empty environment by one line, and it works there",
    2: "types what the README says, and gets what it says, with the pictures that it shows",
    3: "asks for a report in the first minute, with nothing compiled yet, and has it within seconds",
    4: "asks any command for help, at once, and copies an example that runs",
    5: "asks for a first sensor, and gets a file with comments that runs",
    6: "checks a file before a run, and is told all faults at once",
    7: "makes a mistake, and is told where, what was found and what to write instead",
    8: "misspells a name, and is asked whether the right one was meant",
    9: "gives it any nonsense, and never sees a traceback that was not asked for",
    10: "calls it from a script, and knows from the exit code what went wrong",
    11: "looks for a block by its name, its purpose or another tool's word, and sees all that is declared",
    12: "opens a file in an editor, and has the mistake underlined and nothing else",
    13: "writes quantities in any unit, and sees them again as they were written",
    14: "changes any parameter, rate or length from the shell, without touching the file",
    15: "sees the graph as a diagram that can be read",
    16: "works in a notebook, and results, tables and figures show themselves",
    17: "writes the same graph in Python or in TOML, and goes from one to the other",
    18: "writes a block of their own in one file, and uses it like any other",
    19: "has a block of their own tested by one command",
    20: "steps through a block with a debugger",
    21: "looks at any signal without changing the file",
    22: "is told block and tick where a number is no longer finite",
    23: "sees how far a long run is, on a terminal, and no trace of it elsewhere",
    24: "stops a run by Ctrl-C, at once, without losing what was done",
    25: "gives the same command again, and it goes on where it was",
    26: "finds in a result what it was made with",
    27: "opens results in other programs",
    28: "hands on a report that is one file and needs no network",
    29: "gets pictures whose axes and lines have names and units",
    30: "gets margins that python-control confirms, with Bode and Nyquist diagrams",
    31: "gets an Allan deviation with the words and units of data sheets",
    32: "describes a Monte Carlo study in a file, and gets tables and pictures",
    33: "learns which parameter moves a figure, and by how much",
    34: "replays one sensor of a study, bit for bit",
    35: "spreads a study over threads and machines, and gets the same bits",
    36: "compares two files, runs or studies, and is told what differs",
    37: "finds a page for a task, a word or the tool that they come from",
    38: "looks up a fault by its code",
    39: "learns which block takes the time of a run",
    40: "knows what will not change, and that tests hold it",
    41: "has folders with spaces and umlauts",
    42: "has completion, and tables and colours that suit the terminal",
}
MOST = 2 * len(EXPECTED)


class FriendlinessTable(MarkedTable):
    """Prints each row with its score and its tests, and the sum of the scores."""

    marker = "friendly"

    def row(self, mark: pytest.Mark) -> Row:
        """Number, and what the test shows."""
        number, what = mark.args
        return str(number), what

    def order(self, row: Row) -> tuple[str | int, ...]:
        """By number."""
        return int(row[0]), row[1]

    def lines(self, row: Row, test: str, outcome: str) -> list[str]:
        """What the test shows, its name and how it went."""
        number, what = row
        return [f"{number:>2}  {what}", f"      {test}: {outcome}"]

    def pytest_deselected(self, items: Sequence[pytest.Item]) -> None:
        """Forget what is left out of this run, such as larger samples of a test: it says nothing."""
        for item in items:
            self.rows.pop(item.nodeid, None)

    def scores(self) -> dict[int, int]:
        """Return the points of each row."""
        went: dict[int, list[bool]] = defaultdict(list)
        for node, rows in self.rows.items():
            outcomes = self.outcomes[node]
            for number in {int(row[0]) for row in rows}:
                went[number].append(bool(outcomes) and set(outcomes) == {"passed"})
        return {number: any(went[number]) + (any(went[number]) and all(went[number])) for number in EXPECTED}

    def summary(self, rows: Sequence[Row]) -> str:
        """What a person does in each row, and its points; last the sum."""
        scores = self.scores()
        lines = [f"{number:>2}: {scores[number]}  A person {expected}." for number, expected in EXPECTED.items()]
        below = [str(number) for number, points in scores.items() if points < 2]
        told = f"below 2: {', '.join(below)}" if below else "nothing below 2"
        return "\n".join(["", *lines, "", f"{sum(scores.values())} of {MOST}, {told}"])


def friendly_marks(folder: Path) -> list[tuple[int, str]]:
    """Return what each mark in the tests below a folder says, without running any."""
    marks = []
    for path in sorted(folder.rglob("test_*.py")):
        text = path.read_text(encoding="utf-8")
        if "mark.friendly" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
            for decorator in getattr(node, "decorator_list", []):
                if isinstance(decorator, ast.Call) and ast.unparse(decorator.func) == "pytest.mark.friendly":
                    number, what = map(ast.literal_eval, decorator.args)
                    marks.append((number, what))
    return marks
