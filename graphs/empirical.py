"""An empirical distribution: one column of a CSV file beside the study, a measured lot say."""

import csv
from pathlib import Path

from proofmass.blocks.problem import shown
from proofmass.blocks.units import UnitError, convert
from proofmass.graphs.hints import like
from proofmass.graphs.part_files import PartError, file_inside
from proofmass.graphs.table_entries import TableError

LARGEST_FILE = 1 << 22  # bytes
MOST_VALUES = 100_000


def read_column(file: object, column: object, folder: str, unit: str) -> tuple[float, ...]:
    """The numbers of a column in ascending order, in the unit; its head may say its own: `offset [mV]`.

    Raises `TableError`.
    """
    try:
        path = file_inside(file, folder)
    except PartError as error:
        raise TableError(str(error), "file", shown(file), hint=error.hint) from None
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise TableError("the file is too large", "file", shown(file), f"at most {LARGEST_FILE >> 20} MiB")
        rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines(), strict=True, skipinitialspace=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise TableError(f"cannot be read: {error}", "file", shown(file)) from None
    heads = [_head(head) for head in rows[0]] if rows else []
    names = [name for name, _ in heads]
    if column not in names:
        hint = like(str(column), names, "its columns")
        raise TableError("the file has no such column", "column", shown(column), hint=hint)
    place = names.index(str(column))
    own = heads[place][1] or unit
    values = [_value(row, place, number, own, unit, path) for number, row in enumerate(rows[1:], 2) if row]
    if not 1 <= len(values) <= MOST_VALUES:
        raise TableError("holds no list of values", "file", f"{len(values)} rows", f"1 to {MOST_VALUES:,} rows")
    return tuple(sorted(values))


def _head(text: str) -> tuple[str, str]:
    name, _, unit = text.partition("[")
    return name.strip(), unit.strip().removesuffix("]")


def _value(row: list[str], place: int, line: int, own: str, unit: str, path: Path) -> float:
    text = row[place].strip() if place < len(row) else ""
    try:
        float(text)
        return convert(f"{text} {own}" if own != "1" else text, unit)
    except (ValueError, UnitError) as error:
        hint = getattr(error, "hint", "")
        raise TableError(f"{path.name}, line {line}: not a number in {unit}", "file", shown(text), hint=hint) from None
