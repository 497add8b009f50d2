"""Results as files for other tools: netCDF, CSV, Parquet, and a summary as JSON.

Every file appears whole or not at all: it is written under another name beside it, flushed to disk,
then renamed. Long traces are read and written piece by piece. Errors of the disk are raised as
`OSError`.
"""

import csv
import io
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.host.named_files import named
from proofmass.runner.output.json_text import json_text
from proofmass.runner.run.result import Result, Trace, pieces

LARGEST_CSV = 200_000_000  # numbers: about 4 GB of text, minutes to write and to read


@contextmanager
def whole_file(path: str | Path) -> Iterator[BinaryIO]:
    """Give a file to write to that replaces `path` on success, and is removed on failure."""
    path = Path(path)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with named(path):
            with part.open("w+b") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink()
        raise


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write a text or bytes to a file, whole or not at all."""
    with whole_file(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)
    return Path(path)


@contextmanager
def whole_csv(path: str | Path) -> Iterator[Any]:
    """Give a writer of rows to a CSV file that appears whole or not at all."""
    with whole_file(path) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="")
        yield csv.writer(text, lineterminator="\n")
        text.flush()
        text.detach()


def save_dataset(dataset: Any, path: str | Path) -> Path:
    """Write a dataset of xarray as netCDF-4; put together in memory, since HDF5 does not survive a full disk."""
    need("h5netcdf", "xarray")
    # start-up time: only files in this format need it
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    memory = io.BytesIO()
    with h5netcdf.File(memory, "w") as data:
        dataset.dump_to_store(H5NetCDFStore(data))
    return write_whole(path, memory.getvalue())


def save_netcdf(result: Result, path: str | Path) -> Path:
    """One netCDF-4 file: a variable per probe with its unit and doc, on labelled axes of time; xarray opens it."""
    need("h5netcdf")
    # start-up time: only files in this format need it
    import h5netcdf

    with whole_file(path) as file:
        guarded = _Guarded(file)
        with h5netcdf.File(guarded, "w") as data:
            data.attrs.update(result.attributes())
            for dimension, traces in result.axes().items():
                _write_axis(data, dimension, traces, guarded)
        guarded.check()
    return Path(path)


def save_csv(result: Result, folder: str | Path) -> list[Path]:
    """`traces.csv`, and `traces_2.csv` ... for probes of other rates: names and units in the head, then numbers.

    The numbers read back exactly; a vector has a column per entry. Raises `ModelError` for more
    than 2e8 numbers.
    """
    axes = list(result.axes().values())
    size = max((len(traces[0].values) * (1 + sum(t.entries for t in traces)) for traces in axes), default=0)
    if size > LARGEST_CSV:
        problem = Problem(
            message="the traces are too long for CSV",
            key="probes",
            got=f"{size:.3g} numbers",
            expected=f"at most {LARGEST_CSV:.0e} numbers in a file",
            hint="write netCDF or Parquet, or record one row in many: { signal = ..., every = 10 }",
        )
        raise result.graph.placed(problem).error
    paths = _paths(folder, "csv", len(axes))
    for path, traces in zip(paths, axes, strict=True):
        with whole_file(path) as file:
            file.write((",".join(f"{name} [{unit}]" for name, unit, _ in _head(traces)) + "\n").encode())
            for columns in _columns(traces):
                texts = [map(repr, _numbers(column)) for column in columns]
                file.write("".join(",".join(row) + "\n" for row in zip(*texts, strict=True)).encode())
    return paths


def save_parquet(result: Result, folder: str | Path) -> list[Path]:
    """`traces.parquet`, and `traces_2.parquet` ... for probes of other rates; a vector has a column per entry.

    Each field says its unit and doc as `unit` and `doc` in its metadata; graph, seed and versions
    are in the schema's.
    """
    axes = list(result.axes().values())
    paths = _paths(folder, "parquet", len(axes))
    for path, traces in zip(paths, axes, strict=True):
        kinds = ["float64", *(str(t.values.dtype) for t in traces for _ in range(t.entries))]
        write_parquet(path, _head(traces), kinds, result.attributes(), _columns(traces))
    return paths


def write_parquet(
    path: str | Path,
    heads: Iterable[tuple[str, str, str]],
    kinds: Sequence[str],
    attributes: Mapping[str, str],
    pieces_of_columns: Iterable[Sequence[Any]],
) -> None:
    """Write columns, piece by piece: name, unit and doc of each, its type by the name that Arrow has for it."""
    need("pyarrow")
    # start-up time: only files in this format need it
    import pyarrow
    import pyarrow.parquet

    fields = [
        pyarrow.field(name, pyarrow.type_for_alias(kind), metadata={"unit": unit, "doc": doc})
        for (name, unit, doc), kind in zip(heads, kinds, strict=True)
    ]
    schema = pyarrow.schema(fields, metadata=attributes)
    with whole_file(path) as file, pyarrow.parquet.ParquetWriter(file, schema) as writer:
        for columns in pieces_of_columns:
            arrays = [pyarrow.array(column, field.type) for column, field in zip(columns, fields, strict=True)]
            writer.write_batch(pyarrow.record_batch(arrays, schema=schema))


def save_summary(result: Result, path: str | Path) -> Path:
    """Write provenance, ticks, times taken and statistics of each probe as JSON."""
    data = {
        **result.attributes(),
        "seed": result.seed,
        "ticks": result.ticks,
        "planned_ticks": result.planned_ticks,
        "interrupted": result.interrupted,
        "digest": result.digest,
        "seconds": result.seconds,
        "preparation_seconds": result.preparation,
        "signals": result.summary(),
        "overflows": dict(result.overflows),
        "measures": {name: measure.as_data() for name, measure in result.measures.items()},
    }
    return write_whole(path, json_text(data, ensure_ascii=False) + "\n")


class _Guarded:
    """A file for HDF5, which crashes the process when a write fails: keeps the first error, to be raised afterwards."""

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._error = file, list[OSError]()
        self.read, self.seek, self.tell = file.read, file.seek, file.tell

    def write(self, data: Any) -> int:
        self._try(self._file.write, data)
        return len(data)

    def truncate(self, size: int) -> int:
        self._try(self._file.truncate, size)
        return size

    def flush(self) -> None:
        self._try(self._file.flush)

    def check(self) -> None:
        """Raise the first error, if there was one."""
        if self._error:
            raise self._error[0]

    def _try(self, action: Any, *arguments: Any) -> None:
        if not self._error:
            try:
                action(*arguments)
            except OSError as error:
                self._error.append(error)


def _write_axis(data: Any, dimension: str, traces: list[Trace], guarded: _Guarded) -> None:
    rows = len(traces[0].values)
    data.dimensions[dimension] = rows
    time = data.create_variable(dimension, (dimension,), np.float64)
    time.attrs.update(units="s", long_name="time")
    for first, last in pieces(rows):
        time[first:last] = traces[0].times_of(first, last)
    for trace in traces:
        entries = [f"{trace.signal}_entry{i or ''}" for i in range(trace.values.ndim - 1)]
        for entry, size in zip(entries, trace.values.shape[1:], strict=True):
            data.dimensions[entry] = size
        logical = trace.values.dtype == bool
        variable = data.create_variable(trace.signal, (dimension, *entries), np.int8 if logical else trace.values.dtype)
        variable.attrs.update(trace.facts)
        if logical:
            variable.attrs["dtype"] = "bool"  # as in xarray: netCDF has no type for it
        for first, last in pieces(rows, trace.entries):
            guarded.check()
            variable[first:last] = trace.values[first:last]


def _paths(folder: str | Path, suffix: str, axes: int) -> list[Path]:
    Path(folder).mkdir(parents=True, exist_ok=True)
    return [Path(folder) / f"traces{f'_{i + 1}' if i else ''}.{suffix}" for i in range(axes)]


def _head(traces: Sequence[Trace]) -> list[tuple[str, str, str]]:
    """Return name, unit and doc of each column: time, then signals, with a column for each entry of a vector."""
    head = [("time", "s", "Time since the start.")]
    for trace in traces:
        if trace.values.ndim == 1:
            head.append((trace.signal, trace.unit, trace.doc))
        else:
            head += [(f"{trace.signal}[{i}]", trace.unit, trace.doc) for i in range(trace.entries)]
    return head


def _columns(traces: Sequence[Trace]) -> Iterator[list[AnyArray]]:
    """Yield columns in the order of the head, piece by piece."""
    for first, last in pieces(len(traces[0].values), 1 + sum(trace.entries for trace in traces)):
        columns = [traces[0].times_of(first, last)]
        for trace in traces:
            columns += list(trace.values[first:last].reshape(last - first, -1).T)
        yield columns


def _numbers(column: AnyArray) -> list[float]:
    """Return Python numbers, whose repr reads back exactly; truth values as 0 and 1."""
    return list((column.astype(np.int8) if column.dtype == bool else column).tolist())
