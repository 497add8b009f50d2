"""Recorded signals: CSV, Parquet or netCDF, read into the buffers of the block that plays them."""

import csv
import hashlib
import math
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, pairwise, product
from pathlib import Path
from typing import Any, NamedTuple

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.problem import Problem, did_you_mean, shown
from proofmass.blocks.declaration.unit_expressions import UnitError, is_unit
from proofmass.blocks.declaration.units import convert_exactly, same_dimension
from proofmass.graphs.model.flatten import FlatGraph

LARGEST_FILE = 2 << 30
MOST_ROWS = 1 << 24  # of a file: compressed ones hold any number
MOST_ENTRIES = 1 << 14  # of a vector that are columns: a variable of more is a picture, say
PIECE = 1 << 16  # rows that are read together
LATEST_START = 1e8  # seconds, three years: a recording that begins later is stamped with dates
KEPT_NUMBERS = 1 << 24  # numbers of CSV recordings that a process keeps, over all blocks and plans

_HEAD = re.compile(r"(?P<name>.*?)(?:\s+\[(?P<unit>[^][]*)\]|\[(?P<tight>[^][]*[^][0-9][^][]*)\])")

_ROUND_HEAD = re.compile(r"(?P<name>.*?)\s+\((?P<unit>.*[^0-9].*)\)")  # a number tells columns apart

_ENTRY = re.compile(r"(.+)\[(\d{1,9})\]")

# What netCDF puts where nothing was written, unless a variable says; bytes have no such value.
_UNWRITTEN = {
    "f4": 15.0 * 2.0**119, "f8": 15.0 * 2.0**119,
    "i2": 1 - 2**15, "i4": 1 - 2**31, "i8": 2 - 2**63, "u2": 2**16 - 1, "u4": 2**32 - 1, "u8": 2**64 - 2,
}  # fmt: skip


class Column(NamedTuple):
    """One column of a recording: name without unit, unit or "", and numbers, all finite."""

    name: str
    unit: str
    values: "array[float]"


ColumnPair = tuple[Column, Column]
Choice = Callable[[Sequence[str]], tuple[int, int]]  # of two columns, from the names of all


class RecordingError(ValueError):
    """A recording cannot be played; holds the line, if any, and the parameter to look at."""

    def __init__(self, message: str, line: int = 0, hint: str = "", parameter: str = "file") -> None:
        super().__init__(message)
        self.line, self.hint, self.parameter = line, hint, parameter


def read_recordings(graph: FlatGraph, name: str) -> dict[str, tuple[float, ...]]:
    """The recorded buffers of a block, by name; empty for a block that plays no recording.

    The first column is time. A unit stands in brackets, [V] or (V), after the name of a CSV or Parquet column,
    and in the attribute `units` of a netCDF variable. Numbers without a unit are in the unit of the
    block.
    """
    block = graph.blocks[name]
    quantities = {buffer: declared.recorded for buffer, declared in type(block).buffers.items() if declared.recorded}
    if not quantities:
        return {}
    file = str(getattr(block, "file", ""))
    path = Path(graph.root.place.folder) / file
    unit = unit_of(block, next(iter(type(block).outputs.values())))
    try:
        if not file:
            raise RecordingError("says no file", hint='write file = "recording.csv"')
        column = str(getattr(block, "column", ""))
        read = _played(path, column, unit)
    except RecordingError as error:
        problem = Problem(
            message=str(error),
            file=str(path) if error.line else "",
            line=error.line,
            got=str(path) if file else "",
            hint=error.hint,
            path=("blocks", name, error.parameter),
        )
        raise graph.placed(problem).error from None
    return {buffer: read[quantity] for buffer, quantity in quantities.items()}


_kept: dict[tuple[str, ...], dict[str, tuple[float, ...]]] = {}


def _played(path: Path, column: str, unit: str) -> dict[str, tuple[float, ...]]:
    """Times and values of a recording; a CSV file of the same content is read once in a process."""
    key: tuple[str, ...] = ()
    if path.suffix.lower() == ".csv" and path.is_file() and path.stat().st_size <= LARGEST_FILE:
        with path.open("rb") as file:
            key = (hashlib.file_digest(file, "sha256").hexdigest(), column, unit)
    if key in _kept:
        return _kept[key]
    time, value = read_columns(path, lambda names: (0, _chosen(names, column)))
    read = {"time": tuple(_converted(time, "s")), "value": tuple(_converted(value, unit))}
    _ascending(read["time"])
    _refuse_dates(read["time"])
    if key:
        _kept[key] = read
        while sum(2 * len(entry["time"]) for entry in _kept.values()) > KEPT_NUMBERS and len(_kept) > 1:
            del _kept[next(iter(_kept))]
    return read


def read_columns(path: Path, choice: Choice) -> ColumnPair:
    """Two columns of a CSV, Parquet or netCDF file; raises `RecordingError`.

    Entries of vectors are columns, `sums[3]`. In a netCDF file of several time axes the first name,
    "time", stands for the axis of the other column.
    """
    readers: dict[str, Callable[[Path, Choice], ColumnPair]] = {
        ".csv": _read_csv, ".parquet": _read_parquet, ".nc": _read_netcdf,
    }  # fmt: skip
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise RecordingError("is not a CSV, Parquet or netCDF file", hint=f"the name must end in {', '.join(readers)}")
    try:
        if path.exists() and not path.is_file():
            raise RecordingError("is not a file")
        if path.stat().st_size > LARGEST_FILE:
            raise RecordingError("is larger than 2 GiB", hint="cut it into recordings of their own")
        columns = reader(path, lambda names: _once(names, choice(names)))
        if not columns[0].values:
            raise RecordingError("holds no rows")
        return columns
    except RecordingError:
        raise
    except FileNotFoundError:
        raise RecordingError("there is no such file", hint=_near(path, list(readers))) from None
    except Exception as error:  # the libraries raise errors of many kinds on damaged files
        lines = str(error).splitlines() or [repr(error)]
        raise RecordingError(f"cannot be read: {lines[0]}") from None


def _once(names: Sequence[str], chosen: tuple[int, int]) -> tuple[int, int]:
    """Return the columns that are chosen, whose names no other column has."""
    for name in (names[index] for index in chosen):
        if (times := names.count(name)) > 1:
            raise RecordingError(f"has {times} columns {name!r}", hint="rename them", parameter="column")
    return chosen


def _near(path: Path, suffixes: list[str]) -> str:
    try:
        names = [other.name for other in path.parent.iterdir() if other.suffix.lower() in suffixes]
    except OSError:
        return f"there is no folder {path.parent}"
    return did_you_mean(path.name, names, "the files there")


def _read_csv(path: Path, choice: Choice) -> ColumnPair:
    at = 0  # the line read last

    def rows_of(file: Iterable[str]) -> Iterator[str]:
        nonlocal at
        for at, line in enumerate(file, 1):  # noqa: B007
            if line.strip() and not line.startswith("#"):
                yield line

    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = csv.reader(rows_of(file), strict=True, skipinitialspace=True)
        try:
            heads = [split_unit(cell) for cell in next(rows, [])]
            if len(heads) < 2 or any(_number(name) is not None for name, _ in heads):
                hint = "separate the columns by commas" if len(heads) == 1 and ";" in heads[0][0] else ""
                raise RecordingError("needs a row of column names such as time [s],acceleration [m/s^2]", at or 1, hint)
            chosen = choice([name for name, _ in heads])
            columns = array("d"), array("d")
            for cells in rows:
                _refuse_many(len(columns[0]) + 1)
                if len(cells) != len(heads):
                    raise RecordingError(f"has {len(cells)} cells where the head has {len(heads)}", at)
                for column, index in zip(columns, chosen, strict=True):
                    number = _number(cells[index])
                    if number is None:
                        raise RecordingError(f"holds {cells[index][:40]!r}, which is not a finite number", at)
                    column.append(number)
        except csv.Error as error:
            raise RecordingError(str(error), at) from None
    return Column(*heads[chosen[0]], columns[0]), Column(*heads[chosen[1]], columns[1])


def _read_parquet(path: Path, choice: Choice) -> ColumnPair:
    need("pyarrow")
    # start-up time: only files in this format need it
    import pyarrow.parquet

    with pyarrow.parquet.ParquetFile(path, memory_map=True) as file:
        fields = list(file.schema_arrow)
        heads = [split_unit(field.name) for field in fields]
        chosen = choice([name for name, _ in heads])
        _refuse_many(file.metadata.num_rows)

        def column(index: int) -> Column:
            unit = heads[index][1] or (fields[index].metadata or {}).get(b"unit", b"").decode()
            batches = file.iter_batches(PIECE, columns=[fields[index].name])
            return _column(heads[index][0], unit, (batch.column(0).to_pylist() for batch in batches))

        return column(chosen[0]), column(chosen[1])


def _read_netcdf(path: Path, choice: Choice) -> ColumnPair:
    with path.open("rb") as file:
        classic = file.read(3) == b"CDF"
    return _read_classic(path, choice) if classic else _read_netcdf4(path, choice)


def _read_netcdf4(path: Path, choice: Choice) -> ColumnPair:
    need("h5netcdf")
    # start-up time: only files in this format need it
    import h5netcdf

    with h5netcdf.File(path, "r") as file:
        return _of_variables({name: _Variable(v, v.attrs) for name, v in file.variables.items()}, choice)


def _read_classic(path: Path, choice: Choice) -> ColumnPair:
    """Columns of a netCDF file of version 3, which is not HDF5."""
    # start-up time: only files in this format need it
    from scipy.io import netcdf_file

    with netcdf_file(path, "r", mmap=False) as file:
        return _of_variables({name: _Variable(v, _texts(v._attributes)) for name, v in file.variables.items()}, choice)


def _texts(attributes: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value.decode() if isinstance(value, bytes) else value for name, value in attributes.items()}


class _Variable(NamedTuple):
    """A variable of a netCDF file of either version: `held` has dimensions, shape and slices."""

    held: Any
    attributes: Mapping[str, Any]


def _of_variables(variables: Mapping[str, _Variable], choice: Choice) -> ColumnPair:
    """The variable that is chosen, or an entry of a vector, and its times."""
    series = {name: v for name, v in variables.items() if len(v.held.shape) == 1}
    times = [name for name, v in series.items() if name == "time" or (name,) == v.held.dimensions]
    axes = {series[name].held.dimensions[0] for name in times}
    columns = dict[str, tuple[_Variable, tuple[int, ...]]]()
    for name, v in variables.items():
        if name in series and name not in times:
            columns[name] = v, ()
        elif len(v.held.shape) > 1 and v.held.dimensions[0] in axes and math.prod(v.held.shape[1:]) <= MOST_ENTRIES:
            places = product(*map(range, v.held.shape[1:]))
            columns |= {f"{name}[{number}]": (v, place) for number, place in enumerate(places)}
    names = list(columns)
    first, second = choice(["time", *names])
    other = names[second - 1]
    along = columns[other][0].held.dimensions[:1]
    candidates = [names[first - 1]] if first else times
    for name in candidates:
        variable, entry = columns[name] if first else (series[name], ())
        if variable.held.dimensions[:1] == along:
            return _unpacked(name, variable, entry), _unpacked(other, *columns[other])
    if first:
        raise RecordingError(f"{candidates[0]} and {other} are not on one time axis")
    raise RecordingError(f"has no variable with the times of {other}", hint=f"name it {along[0]}")


def _unpacked(name: str, variable: _Variable, entry: tuple[int, ...] = ()) -> Column:
    """A netCDF variable, or an entry of its vectors, unpacked if its attributes say how."""
    # start-up time: only these files need it
    import numpy as np

    held, attributes = variable
    given = [np.ravel(attributes[key]) for key in ("_FillValue", "missing_value") if key in attributes]
    missing = {float(value) for values in given for value in values}
    if "_FillValue" not in attributes:
        missing |= {_UNWRITTEN[kind] for kind in [held[:0].dtype.str[1:]] if kind in _UNWRITTEN}
    limits = [attributes.get("valid_min", -math.inf), attributes.get("valid_max", math.inf)]
    low, *_, high = map(float, np.ravel(attributes.get("valid_range", limits)))  # of what is stored, not scaled
    unsigned = str(attributes.get("_Unsigned", "")).lower() == "true"  # integers of a format that has signed ones alone
    packed = "scale_factor" in attributes or "add_offset" in attributes
    scale, offset = float(attributes.get("scale_factor", 1.0)), float(attributes.get("add_offset", 0.0))
    rows = held.shape[0]
    _refuse_many(rows)

    def pieces() -> Iterator[Sequence[object]]:
        for first in range(0, rows, PIECE):
            piece = held[(slice(first, first + PIECE), *entry)]
            values = stored = piece.tolist()
            if unsigned:
                values = piece.view(piece.dtype.str.replace("i", "u")).tolist()
            if missing or low > -math.inf or high < math.inf:
                pairs = zip(stored, values, strict=True)
                values = [None if s in missing or not low <= v <= high else v for s, v in pairs]
            yield [None if v is None else v * scale + offset for v in values] if packed else values

    return _column(name, str(attributes.get("units", "")), pieces())


def _chosen(names: Sequence[str], wanted: str) -> int:
    """Index of the wanted column, or of the first after time."""
    if len(names) < 2:
        raise RecordingError("needs a column of time and one of values")
    if wanted and wanted not in names[1:]:
        hint = did_you_mean(wanted, names[1:], "its columns")
        raise RecordingError(f"there is no column {wanted!r}", hint=hint, parameter="column")
    return names.index(wanted, 1) if wanted else 1


def _column(name: str, unit: str, pieces: Iterable[Sequence[object]]) -> Column:
    """A column of pieces; raises `RecordingError` at a value that is not a finite number."""
    values = array("d")
    for row, value in enumerate(chain.from_iterable(pieces), 1):
        if value is not None and not isinstance(value, float | int):
            raise RecordingError(f"column {name} holds {shown(value, 40)} in row {row}, which is not a number")
        values.append(math.nan if value is None else value)
        if not math.isfinite(values[-1]):
            raise RecordingError(f"column {name} holds {values[-1]} in row {row}")
    return Column(name, unit, values)


def _refuse_many(rows: int) -> None:
    if rows > MOST_ROWS:
        hint = "cut it into recordings of their own, or keep every tenth row"
        raise RecordingError(f"has more than {MOST_ROWS:,} rows", hint=hint)


def _converted(column: Column, unit: str) -> Sequence[float]:
    values = column.values
    stated = column.unit or unit
    try:
        if not same_dimension(stated, unit):
            raise RecordingError(
                f"column {column.name} is in {stated}, not in {unit}", hint=f"set the unit to {stated}"
            )
        factor = convert_exactly(f"1 {stated}", unit)
    except UnitError as error:
        raise RecordingError(f"column {column.name}: {error}", hint=error.hint) from None
    if factor.numerator == 1:  # milli, micro: divided, each number is rounded once
        return values if factor == 1 else [value / factor.denominator for value in values]
    return [value * float(factor) for value in values]


def _refuse_dates(times: Sequence[float]) -> None:
    """Refuse dates as times: a run begins at 0 s and would play the first value for ever."""
    if times[0] > LATEST_START and times[-1] - times[0] < times[0]:
        message = f"its first time is {times[0]:.10g} s, which looks like a date: a run begins at 0 s"
        raise RecordingError(message, hint=f"subtract {times[0]:.10g} s from its times")


def _ascending(times: Sequence[float]) -> None:
    for row, (before, after) in enumerate(pairwise(times), 2):
        if after <= before:
            raise RecordingError(f"its time does not grow from row {row - 1} to row {row}: {before:g} s, {after:g} s")


def split_unit(head: str) -> tuple[str, str]:
    """Name and unit of a head such as `rate [deg/s]` or `rate (deg/s)`; in `sums[3]` it is an entry's number."""
    found = _HEAD.fullmatch(head.strip())
    if found:
        return found["name"], (found["unit"] or found["tight"] or "").strip()
    found = _ROUND_HEAD.fullmatch(head.strip())
    return (found["name"], found["unit"].strip()) if found and is_unit(found["unit"].strip()) else (head.strip(), "")


def split_entry(column: str) -> tuple[str, int | None]:
    """The vector and the entry that a column is of, `sums[3]`; no entry of other columns."""
    named = _ENTRY.fullmatch(column)
    return (named[1], int(named[2])) if named else (column, None)


def _number(cell: str) -> float | None:
    """The finite number in a cell, or None."""
    try:
        number = float(cell)
    except ValueError:
        return None
    return number if math.isfinite(number) and "_" not in cell else None
