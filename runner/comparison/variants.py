"""Variants of a study, the later ones compared with the first: tables, plain data and page."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, count
from pathlib import Path
from typing import Any

from proofmass.runner.comparison.studies import StudyComparison, compare_studies
from proofmass.runner.comparison.tables import Table, save_tables, study_tables
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.json_text import json_text
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.curves import variant_pictures

PAGE, DATA = "variants.html", "variants.json"
LONGEST_NAME = 80  # of a folder: a sweep of lists has longer ones than file systems take
_ABOUT = "Each variant has the same sensors as the first. Their own reports are in the folders beside this page."


def folders_of(out: Path, names: Iterable[str]) -> dict[str, Path]:
    """Return a folder of its own for each variant, numbered where file systems take names for one.

    >>> [folder.name for folder in folders_of(Path("out"), ["cheap, adc.bits = 12", "a b", "a/b"]).values()]
    ['cheap_adc.bits_12', 'a_b', 'a_b_2']
    """
    folders, taken = dict[str, Path](), set[str]()
    for name in names:
        plain = re.sub(r"[^\w.+-]+", "_", name)[:LONGEST_NAME].strip("_.") or "variant"
        numbered = chain([plain], (f"{plain}_{number}" for number in count(2)))
        chosen = next(folder for folder in numbered if folder.casefold() not in taken)
        taken.add(chosen.casefold())
        folders[name] = out / chosen
    return folders


@dataclass(frozen=True, eq=False)
class VariantComparison:
    """Results of the variants of a study by name, and the later ones beside the first."""

    results: Mapping[str, StudyResult]

    @cached_property
    def comparisons(self) -> dict[str, StudyComparison]:
        """Comparisons of the later variants with the first."""
        (_, first), *others = self.results.items()
        return {name: compare_studies(first, result) for name, result in others}

    def tables(self) -> list[Table]:
        """Return the means and yields of each variant beside the first, and what moved."""
        first = next(iter(self.results))
        return [
            Table(f"{name}, after {first}: {table.title}", table.heads, table.rows, table.left)
            for name, comparison in self.comparisons.items()
            for table in study_tables(comparison)[1:]
        ]

    def as_data(self) -> dict[str, Any]:
        """Return the comparisons as plain data."""
        return {name: comparison.as_data() for name, comparison in self.comparisons.items()}

    def save(self, out: Path) -> list[str]:
        """Write a page and the plain data; returns the names of the files."""
        write_whole(out / DATA, json_text(self.as_data(), indent=1) + "\n")
        title = f"{next(iter(self.results.values())).study.graph.name}: variants"
        save_tables(out / PAGE, title, _ABOUT, self.tables(), variant_pictures(self.results))
        return [DATA, PAGE]
