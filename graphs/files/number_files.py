"""Lists of numbers from files: a column of a table, the parts of a grid, a matrix.

    values = { file = "curve.csv", column = "force" }         a column by its head, which may have a unit, force [mN]
    breakpoints = { file = "grid.csv", part = "first column" }  a grid: its heads, and what stands below and beside
    stiffness = { file = "stiffness.mtx" }                    a matrix, row after row: CSV or Matrix Market

Matrix Market is what finite-element programs write: array or coordinate, real or integer, general
or symmetric (Boisvert, Pozo and Remington, The Matrix Market exchange formats, NISTIR 5935, 1996).
"""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown
from proofmass.blocks.declaration.units import convert_exactly
from proofmass.graphs.files.part_files import file_inside
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.limits import FILE_BYTES

LARGEST_LIST = 100_000  # numbers
KEYS = ("file", "column", "part")
PARTS = ("first row", "first column", "rest")
_BANNER = "%%matrixmarket"


def is_number_file(entry: object) -> bool:
    """Return whether an entry of a block's table names a file of numbers instead of having them."""
    return isinstance(entry, Mapping) and "file" in entry


def numbers_of_file(entry: Mapping[str, Any], folder: str, unit: str) -> list[float]:
    """The numbers that an entry names, in a unit; raises `Refusal`."""
    for key in entry:
        if key not in KEYS:
            raise Refusal(f"unknown key {key}", key_hint(key, KEYS, entry))
    if "column" in entry and "part" in entry:
        raise Refusal("has a column and a part, which do not go together", "a column has a head, a grid has parts")
    path = file_inside(entry["file"], folder)
    text = _text(path)
    if text.lower().startswith(_BANNER):
        if len(entry) > 1:
            raise Refusal("a matrix has no column and no part", "take the whole matrix, row after row")
        numbers = _matrix(text, path.name)
    else:
        numbers = _chosen(_rows(text, path.name), entry, path.name, unit)
    if not 0 < len(numbers) <= LARGEST_LIST:
        raise Refusal(f"{path.name} holds {len(numbers):,} numbers, which must lie between 1 and {LARGEST_LIST:,}")
    return numbers


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(FILE_BYTES + 1)
        if len(data) > FILE_BYTES:
            raise Refusal(f"{path.name} is larger than {FILE_BYTES >> 20} MiB")
        return data.decode("utf-8-sig")
    except OSError as error:
        raise Refusal(f"{path.name} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise Refusal(f"{path.name} is not UTF-8 text", "save the file as UTF-8") from None


def _rows(text: str, name: str) -> list[list[str]]:
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines(), strict=True) if row]
    except csv.Error as error:
        raise Refusal(f"{name} is not CSV: {error}") from None
    rows = [row for row in rows if any(row)]
    if not rows:
        raise Refusal(f"{name} holds no values", "one row of numbers or more, separated by commas")
    for place, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise Refusal(f"in row {place + 1} {name} has {len(row)} cells where the first has {len(rows[0])}")
    return rows


def _chosen(rows: list[list[str]], entry: Mapping[str, Any], name: str, unit: str) -> list[float]:
    if "column" in entry:
        heads = [name_and_unit(cell) for cell in rows[0]]
        wanted, names = entry["column"], [head for head, _ in heads]
        if names.count(wanted) != 1:
            hint = did_you_mean(str(wanted), names, f"the columns of {name}")
            raise Refusal(f"no such column: {shown(wanted)}" if wanted not in names else "two columns of it", hint)
        k = names.index(wanted)
        return [_number(row[k], n + 2, name, heads[k][1], unit) for n, row in enumerate(rows[1:])]
    if "part" not in entry:
        return [_number(cell, n + 1, name, "", unit) for n, row in enumerate(rows) for cell in row]
    match entry["part"]:
        case "first row":
            return [_number(cell, 1, name, "", unit) for cell in rows[0][1:]]
        case "first column":
            return [_number(row[0], n + 2, name, "", unit) for n, row in enumerate(rows[1:])]
        case "rest":
            return [_number(cell, n + 2, name, "", unit) for n, row in enumerate(rows[1:]) for cell in row[1:]]
    raise Refusal(f"there is no part {shown(entry['part'])}", did_you_mean(str(entry["part"]), PARTS, "the parts"))


def name_and_unit(cell: str) -> tuple[str, str]:
    """Name and unit of a column: "force [mN]"."""
    name, _, unit = cell.partition("[")
    return name.strip(), unit.strip().removesuffix("]").strip()


def _number(cell: str, row: int, name: str, own: str, unit: str) -> float:
    try:
        return float(convert_exactly(f"{cell} {own}" if own else cell, unit))
    except Refusal as error:
        raise Refusal(f"in row {row} of {name}, {shown(cell)}: {error}", error.hint) from None


def _matrix(text: str, name: str) -> list[float]:
    lines = text.splitlines()
    words = lines[0].lower().split()
    if len(words) != 5 or words[1] != "matrix" or words[2] not in ("array", "coordinate"):
        raise Refusal(f"in row 1 {name} is not a matrix of Matrix Market", "%%MatrixMarket matrix array real general")
    _, _, layout, field, symmetry = words
    if field not in ("real", "integer") or symmetry not in ("general", "symmetric"):
        hint = "write it as real, general or symmetric"
        raise Refusal(f"in row 1 {name} has a matrix that is {field} and {symmetry}", hint)
    body = [line.split() for line in lines[1:] if line.strip() and not line.startswith("%")]
    sizes, entries = _sizes(body[0] if body else (), 2 if layout == "array" else 3, name), body[1:]
    height, width = sizes[0], sizes[1]
    if symmetry == "symmetric" and height != width:
        hint = "write the whole matrix, and general in row 1"
        raise Refusal(f"{name} has {height} rows and {width} columns and is said to be symmetric", hint)
    try:
        places = _places(height, width, symmetry) if layout == "array" else [_place(words) for words in entries]
        values = [float(words[-1]) for words in entries]
    except ValueError:
        raise Refusal(f"{name} holds no values in one of its rows", "write numbers, one entry a row") from None
    if len(values) != (len(places) if layout == "array" else sizes[-1]):
        raise Refusal(f"{name} has {len(values)} rows of numbers, too few rows or too many")
    matrix: list[float | None] = [None] * (height * width)
    for (i, j), value in zip(places, values, strict=True):
        if not (0 <= i < height and 0 <= j < width):
            raise Refusal(f"{name} has an entry out of range: row {i + 1}, column {j + 1}")
        if matrix[i * width + j] is not None:
            hint = "of a symmetric matrix write one side" if symmetry == "symmetric" else "write each entry once"
            raise Refusal(f"{name} has two entries at row {i + 1}, column {j + 1}", hint)
        matrix[i * width + j] = value
        if symmetry == "symmetric":
            matrix[j * width + i] = value
    return [0.0 if value is None else value for value in matrix]


def _sizes(words: Sequence[str], count: int, name: str) -> list[int]:
    """Height, width, and the number of entries where they have places."""
    sizes = [int(word) for word in words if word.isdecimal() and len(word) < 10]
    if not len(sizes) == len(words) == count or not 0 < sizes[0] * sizes[1] <= LARGEST_LIST:
        hint = "below its first row it says height and width" + ", and how many entries follow" * (count == 3)
        raise Refusal(f"{name} is a matrix whose size must lie between 1 and {LARGEST_LIST:,} numbers", hint)
    return sizes


def _places(height: int, width: int, symmetry: str) -> list[tuple[int, int]]:
    """Rows and columns of a full matrix, which is written column after column."""
    return [(i, j) for j in range(width) for i in range(j if symmetry == "symmetric" else 0, height)]


def _place(words: Sequence[str]) -> tuple[int, int]:
    if len(words) != 3:
        raise ValueError
    return int(words[0]) - 1, int(words[1]) - 1
