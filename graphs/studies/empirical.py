"""An empirical distribution: one column of a CSV file beside the study, a measured lot say."""

import csv
import hashlib
import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from decimal import Decimal
from fractions import Fraction

from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown, under
from proofmass.blocks.declaration.units import convert_exactly
from proofmass.graphs.files.number_files import name_and_unit
from proofmass.graphs.files.part_files import file_inside

LARGEST_FILE = 1 << 22  # bytes
MOST_VALUES = 100_000
COLUMN = "value"  # of the files that are written here


def read_column(file: object, column: object, folder: str, unit: str) -> tuple[float, ...]:
    """The numbers of a column in ascending order, in the unit; its head may say its own: `offset [mV]`.

    Raises `Refusal`.
    """
    (values,) = read_columns(file, [(column, unit)], folder)
    return tuple(sorted(values))


def read_columns(file: object, units: Sequence[tuple[object, str]], folder: str) -> list[list[float]]:
    """The numbers of some columns in the order of the file, each in its unit; raises `Refusal`."""
    with under("file", file):
        path = file_inside(file, folder)
    try:
        if path.stat().st_size > LARGEST_FILE:
            expected = f"at most {LARGEST_FILE >> 20} MiB"
            raise Refusal("the file is too large", key="file", got=shown(file), expected=expected)
        rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines(), strict=True, skipinitialspace=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise Refusal(f"cannot be read: {error}", key="file", got=shown(file)) from None
    heads = [name_and_unit(head) for head in rows[0]] if rows else []
    names = [name for name, _ in heads]
    for column, _ in units:
        if column not in names:
            hint = did_you_mean(str(column), names, "its columns")
            raise Refusal("the file has no such column", key="column", got=shown(column), hint=hint)
        if (times := names.count(str(column))) > 1:
            raise Refusal(f"the file has {times} columns of this name", "rename them", key="column", got=shown(column))
    return [_column(rows, heads, names.index(str(column)), unit, path.name) for column, unit in units]


def _column(
    rows: Sequence[Sequence[str]], heads: Sequence[tuple[str, str]], place: int, unit: str, name: str
) -> list[float]:
    try:
        scale = convert_exactly(f"1 {heads[place][1]}", unit) if heads[place][1] else Fraction(1)
    except Refusal as error:
        message, got = f"{name}, line 1: {error}", shown(heads[place][1])
        raise Refusal(message, error.hint, key="column", got=got) from None
    values = [_value(row, place, number, scale, name) for number, row in enumerate(rows[1:], 2) if row]
    if not 1 <= len(values) <= MOST_VALUES:
        expected = f"1 to {MOST_VALUES:,} rows"
        raise Refusal("holds no list of values", key="file", got=f"{len(values)} rows", expected=expected)
    return values


def column_file(values: Iterable[float]) -> tuple[str, bytes]:
    """A CSV file of which a column holds the values, named by the SHA-256 of its content."""
    content = "\n".join([COLUMN, *map(repr, values), ""]).encode()
    return f"{hashlib.sha256(content).hexdigest()}.csv", content


def _value(row: Sequence[str], place: int, line: int, scale: Fraction, file: str) -> float:
    """A decimal, read exactly and rounded once."""
    text = row[place].strip() if place < len(row) else ""
    with suppress(ValueError, OverflowError):
        number = float(text)
        if number and math.isfinite(number) and scale != 1:
            over, under = Decimal(text).as_integer_ratio()
            number = over * scale.numerator / (under * scale.denominator)
        if math.isfinite(number) and (number or not Decimal(text)):  # what is too small is not zero
            return number
    raise Refusal(f"{file}, line {line}: not a number", key="file", got=shown(text))
