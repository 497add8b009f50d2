"""Answers of a study for other tools: influences, indices, yields by age and lifetimes.

As JSON, netCDF, CSV or Parquet; every file appears whole or not at all.
"""

from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.runner.output.export import save_dataset, whole_csv, whole_file, write_whole
from proofmass.runner.output.json_text import json_text
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.influences import StudyInfluences, index_rows
from proofmass.runner.studies.shown.lifetime_rows import lifetime_rows, yield_rows

ENDINGS = {"json": "json", "netcdf": "nc", "csv": "csv", "parquet": "parquet"}  # of the files of each form
ABOUT = {  # description of each file
    "influences": "Effect of one standard deviation of each factor on the measures, by linear regression.",
    "sobol_indices": "Fractions of the variance; noise and drift, which a group of the design shares, are in no index.",
    "yields": "Parts of the sensors within each limit at each age, and never out of it until then; intervals of 95 %.",
    "lifetimes": "When parts of the sensors have left each limit, Weibull's law, and the time out of tolerance.",
}


def save_answers(influences: StudyInfluences, folder: Path, formats: tuple[str, ...] = ()) -> list[str]:
    """Write the tables that have rows as JSON and in other forms, by the names of `ABOUT`; return the files' names."""
    result = influences.result
    savers = {"json": _save_json, "netcdf": _save_netcdf, "csv": _save_csv, "parquet": _save_parquet}
    tables = (influences.rows(), index_rows(result), yield_rows(result), lifetime_rows(result))
    written = []
    for name, rows in zip(ABOUT, tables, strict=True):
        for form in ("json", *formats) if rows else ():
            path = folder / f"{name}.{ENDINGS[form]}"
            savers[form](result, rows, path)
            written.append(path.name)
    return written


def _save_json(result: StudyResult, rows: list[dict[str, Any]], path: Path) -> None:
    data = {"about": ABOUT[path.stem], "digest": result.digest, "rows": rows}
    write_whole(path, json_text(data, indent=1) + "\n")


def _save_csv(result: StudyResult, rows: list[dict[str, Any]], path: Path) -> None:
    with whole_csv(path) as writer:
        writer.writerows([list(rows[0]), *(row.values() for row in rows)])


def _save_parquet(result: StudyResult, rows: list[dict[str, Any]], path: Path) -> None:
    need("pyarrow")
    # start-up time: only files in this format need it
    import pyarrow
    import pyarrow.parquet

    table = pyarrow.table(_columns(rows)).replace_schema_metadata(result.attributes())
    with whole_file(path) as file:
        pyarrow.parquet.write_table(table, file)


def _save_netcdf(result: StudyResult, rows: list[dict[str, Any]], path: Path) -> None:
    need("h5netcdf", "xarray")
    # start-up time: only files in this format need it
    import xarray

    columns = {name: ("row", np.array(column)) for name, column in _columns(rows).items()}
    save_dataset(xarray.Dataset(columns, attrs={"about": ABOUT[path.stem], **result.attributes()}), path)


def _columns(rows: list[dict[str, Any]]) -> dict[str, list[Any]]:
    return {name: [row[name] for row in rows] for name in rows[0]}
