"""The table of `make defects`: what was once silently wrong, hung or crashed, and the test that keeps it right.

A test takes part by its marker: `@pytest.mark.defect("S1", before="what was given", after="what is right")`.
"""

import textwrap
from collections import defaultdict

import pytest

_WIDTHS = (6, 58, 44, 44)


class DefectTable:
    """Collects the outcomes of marked tests, and prints a row for each defect and test."""

    def __init__(self) -> None:
        self.rows: dict[str, tuple[str, str, str]] = {}
        self.outcomes: dict[str, list[str]] = defaultdict(list)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Note what each marked test says."""
        for item in items:
            for mark in item.iter_markers("defect"):
                self.rows[item.nodeid] = (mark.args[0], mark.kwargs["before"], mark.kwargs["after"])

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note how a test went: its call, or a set-up that failed or skipped it."""
        if report.when == "call" or report.outcome != "passed":
            self.outcomes[report.nodeid].append(report.outcome)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Print the table, parameters of one test in one row."""
        rows: dict[tuple[str, str, str, str], list[str]] = defaultdict(list)
        for node, (name, before, after) in self.rows.items():
            rows[name, node.partition("[")[0], before, after] += self.outcomes[node] or ["not run"]
        terminalreporter.section("defects")
        terminalreporter.write_line(_row(("defect", "test", "before", "after")) + "\noutcome")
        for key in sorted(rows, key=lambda key: (key[0][:1], int(key[0][1:]) if key[0][1:].isdigit() else 0, key)):
            outcomes = rows[key]
            told = ", ".join(f"{outcomes.count(kind)} {kind}" for kind in dict.fromkeys(outcomes))
            terminalreporter.write_line(_row(key) + f"\n  {told}")


def _row(cells: tuple[str, str, str, str]) -> str:
    wrapped = [
        textwrap.wrap(cell, width - 2, break_on_hyphens=False) for cell, width in zip(cells, _WIDTHS, strict=True)
    ]
    lines = range(max(map(len, wrapped)))
    return "\n".join(
        "".join((part[i] if i < len(part) else "").ljust(width) for part, width in zip(wrapped, _WIDTHS, strict=True))
        for i in lines
    ).rstrip()
