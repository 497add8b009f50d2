"""The list of `make defects`: what was once silently wrong, hung or crashed, and the test that keeps it right.

A test takes part by its marker: `@pytest.mark.defect("S1", before="what was given", after="what is right")`.
"""

from collections import defaultdict

import pytest


class DefectTable:
    """Collects the outcomes of marked tests, and prints them by defect."""

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
        """Print the list, the parameters of one test as one."""
        rows: dict[tuple[str, str, str, str], list[str]] = defaultdict(list)
        for node, (name, before, after) in self.rows.items():
            rows[name, node.partition("[")[0], before, after] += self.outcomes[node] or ["not run"]
        terminalreporter.section("defects")
        for key in sorted(rows, key=_order):
            name, test, before, after = key
            told = ", ".join(f"{rows[key].count(kind)} {kind}" for kind in dict.fromkeys(rows[key]))
            lines = [f"{name:<5} {test}: {told}", f"      before: {before}", f"      after:  {after}"]
            terminalreporter.write_line("\n".join(lines))


def _order(key: tuple[str, ...]) -> tuple[str, int, tuple[str, ...]]:
    """By letter, then by number."""
    return key[0][:1], int(key[0][1:]) if key[0][1:].isdigit() else 0, key
