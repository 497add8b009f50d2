"""A table of marked tests with how they went, printed below a run, as `make defects` prints one."""

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Sequence

import pytest

Row = tuple[str, ...]


class MarkedTable(ABC):
    """Collects the outcomes of tests that carry one marker, and prints them, the parameters of one test as one."""

    marker: str

    def __init__(self) -> None:
        self.rows: dict[str, list[Row]] = defaultdict(list)
        self.outcomes: dict[str, list[str]] = defaultdict(list)

    @abstractmethod
    def row(self, mark: pytest.Mark) -> Row:
        """Return what a mark says."""

    @abstractmethod
    def lines(self, row: Row, test: str, outcome: str) -> Sequence[str]:
        """Return the lines of one row of the table."""

    def order(self, row: Row) -> tuple[str | int, ...]:
        """Return the key by which rows are sorted."""
        return row

    def summary(self, rows: Sequence[Row]) -> str:
        """Return the last line; empty for none."""
        return ""

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Note what each marked test says."""
        for item in items:
            self.rows[item.nodeid] += [self.row(mark) for mark in item.iter_markers(self.marker)]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note how a test went: its call, or a set-up that failed or skipped it."""
        if report.when == "call" or report.outcome != "passed":
            self.outcomes[report.nodeid].append(report.outcome)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Print the table."""
        outcomes: dict[tuple[Row, str], list[str]] = defaultdict(list)
        for node, rows in self.rows.items():
            for row in rows:
                outcomes[row, node.partition("[")[0]] += self.outcomes[node] or ["not run"]
        terminalreporter.section(f"{self.marker}s")
        for row, test in sorted(outcomes, key=lambda key: (self.order(key[0]), key[1])):
            kinds = outcomes[row, test]
            told = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
            terminalreporter.write_line("\n".join(self.lines(row, test, told)))
        if summary := self.summary([row for row, _ in outcomes]):
            terminalreporter.write_line(summary)
