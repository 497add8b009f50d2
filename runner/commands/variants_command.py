"""Variants of a study: each runs in a folder of its own, and all are compared with the first."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from proofmass.runner.comparison.studies import StudyComparison, compare_studies
from proofmass.runner.comparison.tables import Table, save_tables, study_tables
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.json_text import json_text
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.curves import variant_pictures

PAGE, DATA = "variants.html", "variants.json"


def folder_of(out: Path, name: str) -> Path:
    """Return the folder of a variant.

    >>> folder_of(Path("out"), "cheap, adc.bits = 12").name
    'cheap_adc.bits_12'
    """
    return out / re.sub(r"[^A-Za-z0-9.+-]+", "_", name).strip("_")


def compared(results: Mapping[str, StudyResult]) -> dict[str, StudyComparison]:
    """Return the comparisons of the later variants with the first."""
    (_, first), *others = results.items()
    return {name: compare_studies(first, result) for name, result in others}


def comparison_tables(results: Mapping[str, StudyResult], comparisons: Mapping[str, StudyComparison]) -> list[Table]:
    """Return the means and yields of each variant beside the first, and what moved."""
    first = next(iter(results))
    tables = []
    for name, comparison in comparisons.items():
        for table in study_tables(comparison)[1:]:
            tables.append(Table(f"{name}, after {first}: {table.title}", table.heads, table.rows, table.left))
    return tables


def comparison_data(comparisons: Mapping[str, StudyComparison]) -> dict[str, Any]:
    """Return the comparisons as plain data."""
    return {name: comparison.as_data() for name, comparison in comparisons.items()}


def write_comparison(
    results: Mapping[str, StudyResult], comparisons: Mapping[str, StudyComparison], out: Path
) -> list[str]:
    """Write the comparison as a page and as data; returns the names of the files."""
    write_whole(out / DATA, json_text(comparison_data(comparisons), indent=1) + "\n")
    title = f"{next(iter(results.values())).study.graph.name}: variants"
    verdict = "Each variant has the same sensors as the first. Their own reports are in the folders beside this page."
    save_tables(out / PAGE, title, verdict, comparison_tables(results, comparisons), variant_pictures(results))
    return [DATA, PAGE]
