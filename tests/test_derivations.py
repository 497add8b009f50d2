"""The table of derivations: what it reads from a file of tests, and what it prints."""

from pathlib import Path

import pytest

from proofmass.blocks import HallElement
from tests.derivations import DerivationTable, derivations

FACTS = {"equation": "U = S I B", "source": "a balance of forces", "convention": "field across the plate"}
TEXT = """
import pytest

@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.derivation(
    HallElement, equation="U = S I B", source="a balance of forces", convention="field across the plate"
)
def test_one(n): ...

@pytest.mark.exhaustive
def test_other(): ...
"""


def test_marks_of_a_file_are_read_without_running_it(tmp_path: Path) -> None:
    file = tmp_path / "test_hall.py"
    file.write_text(TEXT)
    assert derivations(file) == [{"block": "HallElement", **FACTS}]


def test_a_row_has_a_line_for_each_fact_and_for_what_was_wrong() -> None:
    table = DerivationTable()
    right = table.row(pytest.mark.derivation(HallElement, **FACTS).mark)
    wrong = table.row(pytest.mark.derivation(HallElement, **FACTS, wrong="S1: off by two").mark)
    lines = table.lines(wrong, "tests/test_hall.py::test_one", "2 passed")
    assert lines[0] == "HallElement (magnetics), test_one: 2 passed"
    assert [line.partition(":")[0].strip() for line in lines[1:]] == [*FACTS, "wrong"]
    assert lines[-1].endswith("S1: off by two")
    assert table.lines(right, "", "")[-1].endswith("nothing")
    assert table.summary([right, wrong]).startswith("1 blocks, 0 of mechanics")
    assert table.summary([right, wrong]).endswith("something was wrong in 1")
