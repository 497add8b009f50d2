"""A study for other tools: netCDF, labelled by run and epoch; CSV and Parquet, with a row per run and epoch.

The columns of a table are run and epoch, those of `DrawnTable`, the measures, and why a run failed;
its numbers are empty then. Every file appears whole or not at all.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from proofmass.graphs.studies.study import EPOCH, FAULT, RUN
from proofmass.runner.output.export import save_dataset, whole_csv, write_parquet
from proofmass.runner.studies.draws.drawn_table import DrawnTable, drawn_columns
from proofmass.runner.studies.outcome.result import StudyResult

_RUNS = 10_000  # drawn again and written together


class ExportColumn(NamedTuple):
    """Name, unit and doc of a column; the unit of a number without one is "1", none of a text."""

    name: str
    unit: str
    doc: str


def columns(result: StudyResult) -> list[ExportColumn]:
    """Return the columns of a table."""
    return [
        ExportColumn(RUN, "1", "Number of the run."),
        ExportColumn(EPOCH, "1", "Number of the epoch, from 0."),
        *(ExportColumn(drawn.name, drawn.unit, drawn.doc) for drawn in drawn_columns(result.study)),
        *(ExportColumn(m.name, m.unit, f"{m.statistic} of {m.signal}") for m in result.measures),
        ExportColumn(FAULT, "", "Why the run failed; empty when it did not."),
    ]


def save_study_netcdf(result: StudyResult, path: str | Path) -> Path:
    """One netCDF-4 file, as `to_xarray` labels it."""
    return save_dataset(result.to_xarray(), path)


def save_study_csv(result: StudyResult, path: str | Path) -> Path:
    """One CSV file, units in its head; the numbers read back exactly."""
    with whole_csv(path) as writer:
        writer.writerow(f"{c.name} [{c.unit}]" if c.unit not in ("", "1") else c.name for c in columns(result))
        for piece in _pieces(result):
            writer.writerows(zip(*map(_texts, piece), strict=True))
    return Path(path)


def save_study_parquet(result: StudyResult, path: str | Path) -> Path:
    """One Parquet file; unit and doc of each column in its metadata, study, seed and versions in those of the file."""
    heads = columns(result)
    kinds = ["int64", "int64", *["float64"] * (len(heads) - 3), "string"]
    write_parquet(path, heads, kinds, result.attributes(), _pieces(result))
    return Path(path)


def _pieces(result: StudyResult) -> Iterator[list[list[Any]]]:
    """Yield the columns of the table, some runs at a time: an entry for each run and epoch."""
    epochs = range(len(result.study.epochs))
    for first in range(0, len(result.numbers), _RUNS):
        some = slice(first, first + _RUNS)
        runs = result.numbers[some].tolist()
        table = DrawnTable(result.study, result.numbers[some])
        measured = (result[measure.name][some].ravel() for measure in result.measures)
        yield [
            [run for run in runs for _ in epochs],
            [epoch for _ in runs for epoch in epochs],
            *(table[drawn].ravel().tolist() for drawn in table.columns),
            *([None if math.isnan(value) else value for value in values.tolist()] for values in measured),
            [result.faults.get((run, epoch), "") for run in runs for epoch in epochs],
        ]


def _texts(column: list[Any]) -> list[Any]:
    return [repr(entry) if isinstance(entry, float) else "" if entry is None else entry for entry in column]
