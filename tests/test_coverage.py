"""The tool that says which branches tests take: the branches that it finds in a small file, and its table."""

from pathlib import Path

import coverage
import pytest

from tests.coverage import Branch, Passing, Room, missing, reasons, table
from tests.nearest import dealt

SOURCE = """\
def sign(value):
    if value > 0:
        return 1
    for part in (1, 2):
        value += part
    return value


def never():
    a = 1
    return a


value = sign(VALUE)
"""


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (1, [(2, 4), (10, 10)]),
        (-1, [(2, 3), (10, 10)]),
    ],
)
def test_a_branch_stands_for_the_lines_that_it_leads_to(
    value: int, expected: list[tuple[int, int]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "blocks" / "some.py"
    file.parent.mkdir()
    file.write_text(SOURCE)
    measured = coverage.Coverage(branch=True, data_file=None, source=[str(tmp_path)], config_file=False)
    with measured.collect():
        exec(compile(SOURCE, str(file), "exec"), {"VALUE": value})
    monkeypatch.setattr("tests.coverage.ROOT", tmp_path)
    left, rooms = missing(measured)
    assert [(branch.line, branch.to) for branch in left] == expected
    assert rooms["blocks"].branches == 4
    assert rooms["blocks"].lines == 10


class Measured:
    """What a run has measured of SOURCE: one test imports the file, which calls `sign` at once, and two call it."""

    def get_data(self) -> "Measured":
        return self

    def contexts_by_lineno(self, _: str) -> dict[int, list[str]]:
        return {1: ["early"], 2: ["early", "late"], 3: ["late"], 9: ["early"], 14: ["early"]}


def test_tests_of_a_line_that_runs_at_import_are_those_of_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not only the first one that imported it, whose context it has."""
    (tmp_path / "some.py").write_text(SOURCE)
    (tmp_path / "seconds.json").write_text('{"early": 2.0, "late": 1.0}')
    for name, value in (("ROOT", tmp_path), ("SECONDS", tmp_path / "seconds.json"), ("measured", lambda _: Measured())):
        monkeypatch.setattr(f"tests.coverage.{name}", value)
    passing = Passing()
    assert passing.of("some.py", 3) == {"late": 1.0}
    for line in (1, 2, 9, 10, 14):
        assert list(passing.of("some.py", line)) == ["late", "early"]


def test_tests_are_dealt_by_name_then_one_of_every_file_as_long_as_there_is_time() -> None:
    seconds = {"a/test_one.py::x": 1.0, "a/test_one.py::y": 3.0, "b/test_two.py::x": 0.5, "b/test_two.py::y": 2.0}
    seconds |= {"c/test_three.py::x": 0.7, "c/test_three.py::y": 9.0}
    one, two, three = (tuple(name for name in seconds if word in name) for word in ("one", "two", "three"))
    assert dealt(seconds, "one", 100.0, 3) == [*one, *two, *three]
    assert dealt(seconds, "one", 100.0, 2) == [*one, *two], "of two files"
    assert dealt(seconds, "one", 5.3, 3) == [*one, *two[:1], *three[:1]], "no time for the second of each"
    assert dealt(seconds, "none", 2.2, 3) == ["b/test_two.py::x", "c/test_three.py::x", "a/test_one.py::x"]


def test_the_table_has_the_sum_of_all_rooms() -> None:
    lines = list(table({"blocks": Room(100, 99, 8, 6), "runner/plan": Room(300, 300, 0, 0)}))
    assert [line.split() for line in lines[1:]] == [
        ["blocks", "100", "99.00", "%", "8", "75.00", "%"],
        ["runner/plan", "300", "100.00", "%", "0", "100.00", "%"],
        ["all", "400", "99.75", "%", "8", "75.00", "%"],
    ]


def test_a_reason_is_of_a_line_that_is_there() -> None:
    for file, line in reasons():
        assert Branch(file, 1, 1).file == file
        source = (Path(__file__).parents[1] / file).read_text(encoding="utf-8").splitlines()
        assert line in [text.strip() for text in source], f"{file}: {line}"
