"""Rows of a ledger that can be read beside damaged ones."""

from collections.abc import Iterator
from typing import Any

import pytest

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.studies.kept.ledger import Ledger


class Damaged(Ledger):
    """Stretches of one run each, of which reading stops at the damaged ones."""

    def __init__(self, bad: set[int]) -> None:
        self.bad = bad

    def _stretches(self, first: int, below: int) -> Iterator[Any]:
        for number in range(first, below):
            if number in self.bad:
                raise Problem(message="damaged").error
            yield number


@pytest.mark.parametrize("bad", [set(), {5}, {0, 9}, {3, 4, 5}, set(range(10))])
@pytest.mark.parametrize("first", [0, 1000])
def test_all_but_the_damaged_rows_are_read(bad: set[int], first: int) -> None:
    """By halves, each run once and in order."""
    ledger = Damaged({first + number for number in bad})
    assert list(ledger.whole(first, first + 10)) == [first + n for n in range(10) if n not in bad]
