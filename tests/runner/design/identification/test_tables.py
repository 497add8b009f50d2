"""Tables of recordings in their dialects, and what is refused of them."""

import math
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.design.identification.tables import RecordedTable, _number, read_table_file


def read(folder: Path, text: str, name: str = "a.csv") -> RecordedTable:
    (folder / name).write_text(text)
    return read_table_file(folder / name, [])


@pytest.mark.parametrize(
    ("text", "notes"),
    [
        ("time [s],force [N]\n0,1.5\n1,2.5\n", ()),
        ("# made by hand\n\ntime [s], force [N]\n0, 1.5\n# more\n1, 2.5\n", ()),
        ("time;force\ns;N\n0;1,5\n1;2,5\n", (
            "line 2 is taken for units: s, N",
            "columns are separated by semicolons, numbers with a decimal comma",
        )),
        ("time\tforce\n[s]\t(N)\n0\t1.5\n1\t2.5\n", (
            "line 2 is taken for units: s, N", "columns are separated by tabs"
        )),
        ("time force\ns N\n0 1.5\n1 2.5\n", (
            "line 2 is taken for units: s, N", "columns are separated by blanks"
        )),
    ],
)  # fmt: skip
def test_dialects(text: str, notes: tuple[str, ...], tmp_path: Path) -> None:
    for name in ("a.csv", "a.txt", "a.TSV", "a.dat"):
        found = read(tmp_path, text, name)
        assert {column: values.tolist() for column, values in found.columns.items()} == {
            "time": [0.0, 1.0], "force": [1.5, 2.5]
        }  # fmt: skip
        assert (found.units, found.notes, found.source) == ({"time": "s", "force": "N"}, notes, str(tmp_path / name))


def test_a_decimal_comma_is_told_of_the_first_rows() -> None:
    assert [_number(cell, ";") for cell in ("1,5", "1,5,5", "1.5", "1_000", "x")] == [1.5, None, 1.5, None, None]
    assert [_number(cell, ",") for cell in ("1,5", "1.5")] == [None, 1.5]
    assert all(math.isnan(_number(cell, ",") or 0.0) for cell in ("", " ", "nan", "NaN", "NA"))


@pytest.mark.parametrize(("row", "told"), [(20, True), (21, False)])
def test_twenty_rows_are_looked_at_for_a_decimal_comma(row: int, told: bool, tmp_path: Path) -> None:
    rows = [f"{k};1" for k in range(30)]
    rows[row - 1] = f"{row};1,5"
    (note,) = read(tmp_path, "\n".join(["time;force", *rows])).notes
    assert note == "columns are separated by semicolons" + ", numbers with a decimal comma" * told


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 0, "holds no rows"),
        ("# nothing\n\n", 0, "holds no rows"),
        ("time,force\n", 0, "holds no rows below its head"),
        ("time,force\ns,N\n", 0, "holds no rows below its head"),
        ("time\n1\n", 1, "needs a row of column names"),
        ("\n0,1\n1,2\n", 2, "needs a row of column names"),
        ("time,a,a,a\n1,2,3,4\n", 1, "has 3 columns 'a'"),
        ("time,force\n0,1\n1\n", 3, "has 1 cells where the head has 2"),
        ("time,force\n0,1\n1,no\n", 3, "column force holds 'no', which is not a number"),
        (f"time,force\n0,1\n1,{'x' * 50}\n", 3, f"column force holds '{'x' * 40}', which is not a number"),
        ("time,force\ns,N,m\n0,1\n", 2, "has 3 cells where the head has 2"),
    ],
)
def test_what_is_refused(text: str, line: int, message: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError) as refused:
        read(tmp_path, text)
    (problem,) = refused.value.problems
    assert (problem.message, problem.line, problem.file) == (message, line, str(tmp_path / "a.csv"))


def test_a_file_that_is_not_there_and_a_column_that_is_not(tmp_path: Path) -> None:
    for name in ("b.csv", "b.parquet"):
        with pytest.raises(ModelError, match="there is no such file"):
            read_table_file(tmp_path / name, ["force"])
    table = read(tmp_path, "time,force\n0,1\n")
    assert table.column("force").tolist() == [1.0]
    with pytest.raises(ModelError, match="has no column forc") as refused:
        table.column("forc")
    assert refused.value.problems[0].key == "forc"
