"""Recorded signals: CSV, Parquet or netCDF, read into the buffers of the block that plays them."""

import csv
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from proofmass.blocks.problem import ModelError, Problem, did_you_mean
from proofmass.blocks.units import UnitError, convert_exactly, same_dimension
from proofmass.graphs.graph import Graph

LARGEST_FILE = 2 << 30


class Column(NamedTuple):
    """One column of a recording: its name without unit, its unit or "", and its numbers."""

    name: str
    unit: str
    values: Sequence[float]


class RecordingError(ValueError):
    """A recording that cannot be played, with the line when there is one."""

    def __init__(self, message: str, line: int = 0, hint: str = "") -> None:
        super().__init__(message)
        self.line, self.hint = line, hint


def read_recordings(graph: Graph, name: str) -> dict[str, list[float]]:
    """The recorded buffers of a block, by name; empty for a block that plays no recording.

    The first column is time. A unit stands in brackets after the name of a CSV or Parquet column, and in the attribute
    `units` of a netCDF variable; without one the numbers are taken to be in the unit of the block.
    """
    block = graph.blocks[name]
    wanted = {buffer: declared.recorded for buffer, declared in block.buffers.items() if declared.recorded}
    if not wanted:
        return {}
    file = str(getattr(block, "file", ""))
    path = Path(graph.place.folder) / file
    try:
        if not file:
            raise RecordingError("says no file", hint='write file = "recording.csv"')
        columns = _read(path)
        time, value = _chosen(columns, str(getattr(block, "column", "")))
        unit = block.unit_of(next(iter(block.outputs.values())))
        read = {"time": _converted(time, "s"), "value": _converted(value, unit)}
        _ascending(read["time"])
    except RecordingError as error:
        problem = Problem(
            message=str(error),
            file=str(path) if error.line else "",
            line=error.line,
            key=f"blocks.{name}.file",
            got=str(path),
            hint=error.hint,
            path=("blocks", name, "file"),
        )
        raise ModelError([problem if error.line else graph.placed(problem)]) from None
    return {buffer: read[quantity] for buffer, quantity in wanted.items()}


def _read(path: Path) -> list[Column]:
    readers: dict[str, Callable[[Path], list[Column]]] = {
        ".csv": _read_csv, ".parquet": _read_parquet, ".nc": _read_netcdf,
    }  # fmt: skip
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise RecordingError("is no CSV, Parquet or netCDF file", hint=f"the name must end in {', '.join(readers)}")
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise RecordingError("is larger than 2 GiB")
        return reader(path)
    except RecordingError:
        raise
    except FileNotFoundError:
        near = did_you_mean(path.name, _names_in(path.parent), "file") if path.parent.is_dir() else ""
        raise RecordingError("there is no such file", hint=near) from None
    except Exception as error:  # the libraries raise errors of many kinds on damaged files
        raise RecordingError(f"cannot be read: {str(error).splitlines()[0] if str(error) else error!r}") from None


def _names_in(folder: Path) -> list[str]:
    return [p.name for p in folder.iterdir() if p.suffix in (".csv", ".parquet", ".nc")]


def _read_csv(path: Path) -> list[Column]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = ((number, line) for number, line in enumerate(file, 1) if line.strip() and not line.startswith("#"))
        head_line, head = next(rows, (0, ""))
        heads = [_split_unit(cell) for cell in next(csv.reader([head]), [])]
        if len(heads) < 2 or any(_is_number(name) for name, _ in heads):
            message = "needs a row of column names such as time [s],acceleration [m/s^2]"
            raise RecordingError(message, head_line or 1)
        values: list[list[float]] = [[] for _ in heads]
        for number, line in rows:
            cells = line.rstrip("\r\n").split(",")
            if len(cells) != len(heads):
                raise RecordingError(f"has {len(cells)} cells where the head has {len(heads)}", number)
            for column, cell in zip(values, cells, strict=True):
                if not _is_number(cell):
                    raise RecordingError(f"holds {cell.strip()[:40]!r}, which is not a finite number", number)
                column.append(float(cell))
    return [Column(name, unit, column) for (name, unit), column in zip(heads, values, strict=True)]


def _read_parquet(path: Path) -> list[Column]:
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    columns = []
    for field, column in zip(table.schema, table.columns, strict=True):
        name, unit = _split_unit(field.name)
        metadata = field.metadata or {}
        columns.append(Column(name, unit or metadata.get(b"unit", b"").decode(), column.to_pylist()))
    return columns


def _read_netcdf(path: Path) -> list[Column]:
    import h5netcdf

    with h5netcdf.File(path, "r") as file:
        columns = [Column(n, str(v.attrs.get("units", "")), v[...].tolist()) for n, v in file.variables.items() if v.ndim == 1]
    return sorted(columns, key=lambda column: not column.name.startswith("time"))


def _chosen(columns: list[Column], wanted: str) -> tuple[Column, Column]:
    names = [column.name for column in columns[1:]]
    if not names:
        raise RecordingError("needs a column of time and one of values")
    if not wanted:
        return columns[0], columns[1]
    for column in columns[1:]:
        if column.name == wanted:
            return columns[0], column
    raise RecordingError(f"has no column {wanted!r}", hint=did_you_mean(wanted, names, "column"))


def _converted(column: Column, unit: str) -> list[float]:
    values = [math.nan if value is None else float(value) for value in column.values]
    if not values:
        raise RecordingError("holds no rows")
    if not all(map(math.isfinite, values)):
        row = next(i for i, value in enumerate(values) if not math.isfinite(value))
        raise RecordingError(f"column {column.name} holds {values[row]} in row {row + 1}")
    given = column.unit or unit
    try:
        if not same_dimension(given, unit):
            raise RecordingError(f"column {column.name} is in {given}, which is no {unit}", hint=f"set the unit to {given}")
        factor = float(convert_exactly(f"1 {given}", unit))
    except UnitError as error:
        raise RecordingError(f"column {column.name}: {error}", hint=error.hint) from None
    return values if factor == 1.0 else [value * factor for value in values]


def _ascending(times: list[float]) -> None:
    for row, (before, after) in enumerate(pairwise(times), 2):
        if after <= before:
            raise RecordingError(f"its time does not grow from row {row - 1} to row {row}: {before:g} s, {after:g} s")


def _split_unit(head: str) -> tuple[str, str]:
    name, bracket, unit = head.strip().partition("[")
    return name.strip(), unit.strip().removesuffix("]").strip() if bracket else ""


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False
