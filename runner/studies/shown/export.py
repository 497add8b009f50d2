"""A study for other tools: netCDF, labelled by run and epoch; CSV and Parquet, with a row per run and epoch.

The columns of a table are run, epoch and age, the time between calibrations where there are some, the parameters
that are spread, swept or drift, the measures, and why a run failed; its numbers are empty then. Every file appears
whole or not at all.
"""

import csv
import io
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.runner.output.export import whole_file
from proofmass.runner.studies.draws.factors import parameters_of
from proofmass.runner.studies.outcome.result import RECALIBRATION, StudyResult

_RUNS = 10_000  # drawn again and written together


class Column(NamedTuple):
    """Name, unit and doc of a column; the unit of a number without one is "1", of a text nothing."""

    name: str
    unit: str
    doc: str


def columns(result: StudyResult) -> list[Column]:
    """Return the columns of a table."""
    study = result.study
    parameters = dict.fromkeys([*study.sweep, *study.spread, *study.drift])
    return [
        Column("run", "1", "Number of the run."),
        Column("epoch", "1", "Number of the epoch, from 0."),
        Column("age", "s", "Age of the sensor."),
        *([Column(RECALIBRATION, "s", "Time between calibrations.")] if study.recalibration.carried else []),
        *(Column(result.column_of(name), study.unit_of(name), "Parameter at this age.") for name in parameters),
        *(Column(m.name, m.unit, f"{m.statistic} of {m.signal}") for m in result.measures),
        Column("fault", "", "Why the run failed; empty when it did not."),
    ]


def save_study_netcdf(result: StudyResult, path: str | Path) -> Path:
    """One netCDF-4 file, as `to_xarray` labels it; put together in memory, since HDF5 does not survive a full disk."""
    need("h5netcdf", "xarray")
    # start-up time: only files in this format need it
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    memory = io.BytesIO()
    with h5netcdf.File(memory, "w") as data:
        result.to_xarray().dump_to_store(H5NetCDFStore(data))
    with whole_file(path) as file:
        file.write(memory.getvalue())
    return Path(path)


def save_study_csv(result: StudyResult, path: str | Path) -> Path:
    """One CSV file, units in its head; the numbers read back exactly."""
    with whole_file(path) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(f"{c.name} [{c.unit}]" if c.unit not in ("", "1") else c.name for c in columns(result))
        for rows in _rows(result):
            writer.writerows([_number(entry) for entry in row] for row in rows)
        text.flush()
        text.detach()
    return Path(path)


def save_study_parquet(result: StudyResult, path: str | Path) -> Path:
    """One Parquet file; unit and doc of each column in its metadata, study, seed and versions in those of the file."""
    need("pyarrow")
    # start-up time: only files in this format need it
    import pyarrow
    import pyarrow.parquet

    heads = columns(result)
    kinds = [pyarrow.int64(), pyarrow.int64(), *[pyarrow.float64()] * (len(heads) - 3), pyarrow.string()]
    fields = [
        pyarrow.field(head.name, kind, metadata={"unit": head.unit, "doc": head.doc})
        for head, kind in zip(heads, kinds, strict=True)
    ]
    schema = pyarrow.schema(fields, metadata=result.attributes())
    with whole_file(path) as file, pyarrow.parquet.ParquetWriter(file, schema) as writer:
        for rows in _rows(result):
            arrays = [pyarrow.array(column, kind) for column, kind in zip(zip(*rows, strict=True), kinds, strict=True)]
            writer.write_batch(pyarrow.record_batch(arrays, schema=schema))
    return Path(path)


def _rows(result: StudyResult) -> Iterator[list[list[Any]]]:
    """Yield rows of the table, piece by piece."""
    study = result.study
    for first in range(0, len(result.numbers), _RUNS):
        some = result.numbers[first : first + _RUNS]
        drawn = np.array(list(parameters_of(study, some).values())).reshape(-1, len(study.epochs), len(some))
        measured = np.array([result[m.name][first : first + _RUNS] for m in result.measures])
        parameters, rows = np.moveaxis(drawn, 0, 2).tolist(), []
        for place, (run, values) in enumerate(zip(some.tolist(), np.moveaxis(measured, 0, 2).tolist(), strict=True)):
            every = [study.recalibrated_every(run)] if study.recalibration.carried else []
            for epoch, age in enumerate(study.epochs):
                numbers = [None if math.isnan(value) else value for value in values[epoch]]
                fault = result.faults.get((run, epoch), "")
                rows.append([run, epoch, age, *every, *parameters[epoch][place], *numbers, fault])
        yield rows


def _number(entry: Any) -> Any:
    return repr(entry) if isinstance(entry, float) else "" if entry is None else entry
