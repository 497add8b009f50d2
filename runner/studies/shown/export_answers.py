"""Answers of a study for other tools: influences, indices, yields by age and lifetimes.

As JSON, netCDF, CSV or Parquet; every file appears whole or not at all.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.runner.output.export import save_dataset, whole_csv, whole_file, write_whole
from proofmass.runner.output.json_text import json_text
from proofmass.runner.studies.outcome.lifetimes import OUT, Lifetimes, lifetimes
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.influences import StudyInfluences, index_rows, point_columns
from proofmass.runner.studies.shown.points import parts

NEITHER = (math.nan, math.nan)
ENDINGS = {"json": "json", "netcdf": "nc", "csv": "csv", "parquet": "parquet"}  # of files
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


def yield_rows(result: StudyResult) -> list[dict[str, Any]]:
    """Return a row for each point, limit and age: the parts within the limit, and never out of it, with intervals."""
    return [row for part in parts(result).values() for lives in lifetimes(part) for row in _ages(part, lives)]


def lifetime_rows(result: StudyResult) -> list[dict[str, Any]]:
    """Return a row for each point and limit: ages at which parts have left, Weibull's law, time out of tolerance."""
    return [_whole(part, lives) for part in parts(result).values() for lives in lifetimes(part)]


def _ages(part: StudyResult, lives: Lifetimes) -> Iterator[dict[str, Any]]:
    for place, (epoch, age) in enumerate(zip(lives.epochs, lives.ages, strict=True)):
        good, left = lives.good_intervals[place], lives.surviving_intervals[place]
        yield (
            point_columns(part)
            | {"limit": lives.limit, "epoch": epoch, "age_s": age, "sensors": lives.sensors}
            | {"good": float(lives.good[place]), "good_low": good[0], "good_high": good[1]}
            | {"never_out": float(lives.surviving[place]), "never_out_low": left[0], "never_out_high": left[1]}
            | {"band": lives.band, "weibull": float(lives.law.survival(np.array(age))) if lives.law else math.nan}
        )


def _whole(part: StudyResult, lives: Lifetimes) -> dict[str, Any]:
    row = point_columns(part) | {"limit": lives.limit, "sensors": lives.sensors}
    for share in OUT:
        after, by = lives.left_at(share) or NEITHER
        low, high = lives.left_interval(share)
        named = f"left_{100 * share:g}_percent"
        row |= {f"{named}_after_s": after, f"{named}_by_s": by, f"{named}_low_s": low, f"{named}_high_s": high}
    law, (low, high) = lives.law, lives.time_out_interval
    row |= {"time_out": lives.time_out, "time_out_low": low, "time_out_high": high}
    for name, value, ends in (
        ("shape", law and law.shape, law and law.shape_interval),
        ("scale_s", law and law.scale, law and law.scale_interval),
        ("left_1_percent_s", law and law.one_percent, law and law.one_percent_interval),
    ):
        low, high = ends or NEITHER
        row |= {f"weibull_{name}": value or math.nan, f"weibull_{name}_low": low, f"weibull_{name}_high": high}
    return row | {"weibull_fits": lives.law_fits}
