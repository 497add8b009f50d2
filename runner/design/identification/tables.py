"""Tables of recorded signals: CSV in its dialects, Parquet and netCDF, all columns at once.

The separator of a CSV file is a comma, a semicolon, a tab or blanks; with all but commas numbers
may have a decimal comma. Lines that begin with # are comments. A head may say a unit, `force [N]`,
and so may a second line.
"""

import csv
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import Problem, did_you_mean
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.recording import LARGEST_FILE, Column, RecordingError, read_columns, split_entry, split_unit

_SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas"}


@dataclass(frozen=True)
class RecordedTable:
    """Columns by name with their units, and remarks about how they were read."""

    source: str
    columns: Mapping[str, AnyArray]
    units: Mapping[str, str]
    notes: tuple[str, ...] = ()

    def column(self, name: str) -> AnyArray:
        """Return a column; raises `ModelError`."""
        if name in self.columns:
            return self.columns[name]
        hint = did_you_mean(name, self.columns, "its columns")
        raise Problem(message=f"has no column {name}", file=self.source, key=name, hint=hint).error


def read_table_file(path: Path, wanted: list[str]) -> RecordedTable:
    """Return the first column and the wanted ones of a file; raises `ModelError`."""
    try:
        if path.suffix.lower() in (".csv", ".txt", ".tsv", ".dat"):
            return _read_text(path)
        return _read_pairs(path, wanted)
    except RecordingError as error:
        raise Problem(message=str(error), file=str(path), line=error.line, hint=error.hint).error from None
    except FileNotFoundError:
        raise Problem(message="there is no such file", file=str(path)).error from None
    except (OSError, UnicodeDecodeError) as error:
        raise Problem(message=f"cannot be read: {error}", file=str(path)).error from None


def table_of_arrays(source: Mapping[Any, Any], name: str) -> RecordedTable:
    """Return a table of arrays, whose names may have units as heads do; raises `ModelError`."""
    heads = [split_unit(str(key)) for key in source]
    names = [head for head, _ in heads]
    for head in names:
        if names.count(head) > 1:
            raise Problem(message=f"has {names.count(head)} columns {head!r}", key=name, hint="rename them").error
    columns = {head: _numbers(head, values, name) for head, values in zip(names, source.values(), strict=True)}
    if "time" in columns:
        columns = {"time": columns["time"], **columns}
    shapes, rows = {key: values.shape for key, values in columns.items()}, next(iter(columns.values())).size
    if any(shape != (rows,) for shape in shapes.values()):
        message, got = "its arrays are not of one length", ", ".join(f"{k} {v}" for k, v in shapes.items())
        raise Problem(message=message, key=name, got=got).error
    return RecordedTable(name, columns, dict(heads))


def table_of_dataset(source: Any, wanted: list[str], name: str) -> RecordedTable:
    """Return the wanted variables of an xarray dataset with the times they are along; raises `ModelError`."""
    held = {str(key): values for key, values in source.data_vars.items()}
    for key in wanted:
        vector, entry = split_entry(key)
        if key in held or entry is None or vector not in held:
            continue
        if entry < math.prod(held[vector].shape[1:]):
            held[key] = held[vector][(slice(None), *np.unravel_index(entry, held[vector].shape[1:]))]
    axes = {key: tuple(map(str, held[key].dims)) for key in wanted if key in held}
    axis = next(iter(axes.values()), tuple(map(str, source.dims))[:1])
    if len(axis) != 1 or any(other != axis for other in axes.values()):
        got = ", ".join(f"{key} along {' and '.join(dims) or 'nothing'}" for key, dims in axes.items())
        raise Problem(message="its columns are not along one axis of time", key=name, got=got).error
    if axis[0] not in source.coords:
        hint = f"give them: dataset.assign_coords({axis[0]}=times)"
        raise Problem(message=f"has no times along {axis[0]}", key=name, hint=hint).error
    along = {axis[0]: source[axis[0]], **{key: v for key, v in held.items() if tuple(map(str, v.dims)) == axis}}
    units = {key: str(values.attrs.get("units", "")) for key, values in along.items()}
    return RecordedTable(name, {key: _numbers(key, values.values, name) for key, values in along.items()}, units)


def _numbers(column: str, values: Any, source: str) -> AnyArray:
    """Return an array as numbers: times of any kind in seconds, dates from the first on, what is masked as missing."""
    array = values if isinstance(values, np.ma.MaskedArray) else np.asarray(values)
    match array.dtype.kind:
        case "M":
            array = array - array[:1]
        case "c":
            raise Problem(message="holds complex numbers", file=source, key=column).error
        case _:
            pass
    if array.dtype.kind == "m":
        return np.asarray(array / np.timedelta64(1, "s"))
    try:
        return np.asarray(np.ma.filled(array.astype(float), np.nan))
    except (TypeError, ValueError) as error:
        raise Problem(message="holds what is not a number", file=source, key=column, got=str(error)).error from None


def _read_text(path: Path) -> RecordedTable:
    if path.is_file() and path.stat().st_size > LARGEST_FILE:
        raise RecordingError("is larger than 2 GiB", hint="cut it into recordings of their own")
    with path.open(newline="", encoding="utf-8-sig") as file:
        numbered = [(at, line) for at, line in enumerate(file, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not numbered:
        raise RecordingError("holds no rows")
    separator = next((s for s in _SEPARATORS if s in numbered[0][1]), None)
    rows = [(at, _cells(line, separator)) for at, line in numbered]
    heads = [split_unit(cell) for cell in rows[0][1]]
    if len(heads) < 2 or any(_number(name, separator) is not None for name, _ in heads):
        hint = "the first line must name the columns: time [s],force [N],displacement [m]"
        raise RecordingError("needs a row of column names", rows[0][0], hint)
    names = [name for name, _ in heads]
    for name in names:
        if names.count(name) > 1:
            message = f"has {names.count(name)} columns {name!r}"
            raise RecordingError(message, rows[0][0], "rename them: which of them is meant cannot be known")
    units = [unit for _, unit in heads]
    body, notes = rows[1:], []
    if body and all(_number(cell, separator) is None for cell in body[0][1]) and len(body[0][1]) == len(names):
        units = [cell.strip("[]() ") or unit for cell, unit in zip(body[0][1], units, strict=True)]
        notes.append(f"line {body[0][0]} is taken for units: {', '.join(filter(None, units))}")
        body = body[1:]
    if separator != ",":
        commas = any("," in cell for _, cells in body[:20] for cell in cells)
        decimal = ", numbers with a decimal comma" if commas else ""
        notes.append(f"columns are separated by {_SEPARATORS.get(separator or '', 'blanks')}{decimal}")
    table = np.empty((len(body), len(names)))
    for row, (at, cells) in enumerate(body):
        if len(cells) != len(names):
            raise RecordingError(f"has {len(cells)} cells where the head has {len(names)}", at)
        for column, cell in enumerate(cells):
            number = _number(cell, separator)
            if number is None:
                raise RecordingError(f"column {names[column]} holds {cell[:40]!r}, which is not a number", at)
            table[row, column] = number
    if not len(table):
        raise RecordingError("holds no rows below its head")
    columns = {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(names)}
    return RecordedTable(str(path), columns, dict(zip(names, units, strict=True)), tuple(notes))


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    cells = next(csv.reader([line.rstrip("\r\n")], delimiter=separator, skipinitialspace=True))
    return [cell.strip() for cell in cells]


def _number(cell: str, separator: str | None) -> float | None:
    """The number in a cell; "nan" and nothing are a value that is missing."""
    if cell.strip().lower() in ("", "nan", "na"):
        return float("nan")
    text = cell.replace(",", ".") if separator != "," and cell.count(",") == 1 and "." not in cell else cell
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None


def _read_pairs(path: Path, wanted: list[str]) -> RecordedTable:
    columns: dict[str, AnyArray] = {}
    units: dict[str, str] = {}

    def pair(name: str) -> Callable[..., tuple[int, int]]:
        def choice(names: list[str]) -> tuple[int, int]:
            if name not in names:
                raise RecordingError(f"has no column {name}", hint=did_you_mean(name, names, "its columns"))
            return 0, names.index(name)

        return choice

    for name in wanted:
        time, column = read_columns(path, pair(name))
        for one in (time, Column(name, column.unit, column.values)):
            columns[one.name], units[one.name] = np.array(one.values), one.unit
        if any(len(values) != len(columns[time.name]) for values in columns.values()):
            raise RecordingError(f"column {name} has a time axis of its own")
    return RecordedTable(str(path), columns, units)
