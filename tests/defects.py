"""The list of `make defects`: what was once silently wrong, hung or crashed, and the test that keeps it right.

A test takes part by its marker: `@pytest.mark.defect("S1", before="what was given", after="what is right")`.
"""

import pytest

from tests.marked import MarkedTable, Row


class DefectTable(MarkedTable):
    """Prints each defect with its test, before and after."""

    marker = "defect"

    def row(self, mark: pytest.Mark) -> Row:
        """Name, before and after."""
        return mark.args[0], mark.kwargs["before"], mark.kwargs["after"]

    def order(self, row: Row) -> tuple[str | int, ...]:
        """By letter, then by number."""
        return row[0][:1], int(row[0][1:]) if row[0][1:].isdigit() else 0, *row

    def lines(self, row: Row, test: str, outcome: str) -> list[str]:
        """Three lines."""
        name, before, after = row
        return [f"{name:<5} {test}: {outcome}", f"      before: {before}", f"      after:  {after}"]
