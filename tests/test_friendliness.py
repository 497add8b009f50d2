"""The table of friendliness: every row has a test that shows it, and points are given for tests that pass."""

from pathlib import Path

import pytest

from tests.friendliness import EXPECTED, MOST, FriendlinessTable, friendly_marks

MARKS = friendly_marks(Path(__file__).parent)


@pytest.mark.exhaustive("1")
@pytest.mark.parametrize("number", EXPECTED)
def test_a_row_has_a_test_that_shows_it(number: int) -> None:
    shown = [what for row, what in MARKS if row == number]
    assert shown, f'no test has @pytest.mark.friendly({number}, "..."): a person {EXPECTED[number]}'
    assert all(len(what) > 10 for what in shown)
    assert len(shown) == len({*shown}), "two tests of a row say the same"


def test_marks_name_rows() -> None:
    assert {row for row, _ in MARKS} <= {*EXPECTED}
    assert list(EXPECTED) == list(range(1, 43))


def test_points_are_for_tests_that_pass() -> None:
    table = FriendlinessTable()
    for name, number, outcomes in (
        ("one", 1, ["passed"]),
        ("two", 1, ["passed"]),
        ("three", 2, ["passed"]),
        ("four", 2, ["skipped"]),
        ("five", 3, ["failed"]),
        ("six", 4, ["passed", "failed"]),
        ("seven", 5, []),
    ):
        table.rows[name].append(table.row(pytest.mark.friendly(number, "what is shown").mark))
        table.outcomes[name] += outcomes
    assert [table.scores()[number] for number in range(1, 7)] == [2, 1, 0, 0, 0, 0]
    last = table.summary([]).splitlines()[-1]
    assert last.startswith(f"3 of {MOST}, below 2: 2, 3, 4, 5, 6, 7")
    for number in EXPECTED:
        table.rows[f"row {number}"] = [(str(number), "what is shown")]
        table.outcomes[f"row {number}"] = ["passed"]
    for name in ("four", "five", "six", "seven"):
        del table.rows[name]
    assert table.summary([]).splitlines()[-1] == f"{MOST} of {MOST}, nothing below 2"


def test_what_is_left_out_of_a_run_counts_for_nothing(request: pytest.FixtureRequest) -> None:
    table = FriendlinessTable()
    table.rows["small"].append(("1", "what is shown"))
    table.outcomes["small"].append("passed")
    table.rows[request.node.nodeid].append(("1", "what is shown"))
    assert table.scores()[1] == 1
    table.pytest_deselected([request.node])
    assert table.scores()[1] == 2


def test_lines_are_in_the_order_of_rows() -> None:
    table = FriendlinessTable()
    rows = [table.row(pytest.mark.friendly(number, "what is shown").mark) for number in (10, 9, 2)]
    assert [row[0] for row in sorted(rows, key=table.order)] == ["2", "9", "10"]
    assert table.lines(rows[0], "tests/test_x.py::test_y", "1 passed") == [
        "10  what is shown",
        "      tests/test_x.py::test_y: 1 passed",
    ]
