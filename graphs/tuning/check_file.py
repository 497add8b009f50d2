"""Everything that is wrong with a file: its graph, the study in it or of it, and what it is to be tuned for."""

from pathlib import Path
from typing import Any, NamedTuple

from proofmass.blocks.declaration.catalog import Own
from proofmass.blocks.declaration.problem import ModelError, Problem, collecting
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_table
from proofmass.graphs.model.graph import Graph, Place
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import (
    STUDY,
    GraphChange,
    graph_in,
    is_study,
    study_of_table,
    unchanged,
)
from proofmass.graphs.tuning.reader import TUNE, tuning_of_table


class CheckedFile(NamedTuple):
    """The graph of a file and the study in it, where they could be read, and all problems with their places."""

    graph: Graph | None
    problems: list[Problem]
    study: Study | None = None


def check_file(path: Path, own: Own | None = None, change: GraphChange = unchanged) -> CheckedFile:
    """Check a graph file or a study file, its graph after a `change`."""
    try:
        return check_table(*read_table(path), own, path, change)
    except ModelError as error:
        return CheckedFile(None, list(error.problems))


def check_table(
    data: dict[str, Any], place: Place, own: Own | None, path: Path | None, change: GraphChange = unchanged
) -> CheckedFile:
    """Check a parsed file of a graph or a study; raises `ModelError` where no graph can be read."""
    graph = change(graph_in(data, place, own, path))
    problems, study = check(graph), None
    is_right = all(problem.note for problem in problems)
    if is_right and (is_study(data) or STUDY in data):
        with collecting(problems):
            study = study_of_table(data, place, graph)
    if is_right and TUNE in data and not is_study(data):
        of_tuning = list[Problem]()
        with collecting(of_tuning):
            tuning_of_table(data, place, graph)
        problems += [problem for problem in of_tuning if problem not in problems]  # it may have read the study too
    return CheckedFile(graph, problems, study)
