"""The table `[tune]` of a graph file."""

import dataclasses
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.catalog import Own
from proofmass.blocks.declaration.problem import ModelError, Problem, collecting
from proofmass.graphs.files.library import file_of
from proofmass.graphs.files.toml_reader import graph_of_file, read_table
from proofmass.graphs.model.graph import Graph, Place
from proofmass.graphs.model.keys import TUNE_KEYS
from proofmass.graphs.studies.study_reader import STUDY, only_study, studies_of_table
from proofmass.graphs.studies.table_entries import unknown_keys
from proofmass.graphs.tuning.build import tuning_of
from proofmass.graphs.tuning.tuning import Tuning

TUNE = "tune"


def read_tuning(path: str | Path, own: Own | None = None) -> Tuning:
    """The tuning of a graph file; raises `ModelError` with every problem that can be seen.

    `path` is a file with a table `[tune]`, or "library:NAME". `own` are the caller's own blocks by
    name.

    >>> from proofmass import read_tuning
    >>> tuning = read_tuning("library:closed_loop_accelerometer")
    >>> list(tuning.free), list(tuning.goals)
    (['pid.proportional', 'pid.integral', 'pid.derivative_gain'], ['phase', 'wide', 'quiet'])
    """
    path = file_of(path)
    data, place = read_table(path)
    return tuning_of_table(data, place, graph_of_file(data, place, own, path))


def tuning_of_table(data: dict[str, Any], place: Place, graph: Graph) -> Tuning:
    """The tuning in a parsed file, of its graph; raises `ModelError`."""
    table: Any = data.get(TUNE)
    of_file, place = place, dataclasses.replace(place, top=(TUNE,))
    if not isinstance(table, dict):
        hint = "add [tune.free] with parameters and bounds, and [tune.goals]"
        raise Problem(message="the graph has no table [tune]", file=place.file, key=TUNE, hint=hint).error
    problems, tuning = list(unknown_keys(table, TUNE_KEYS)), None
    study = only_study(studies_of_table(data, of_file, graph)) if STUDY in data and _asks_study(table) else None
    given = {key: value for key, value in table.items() if key in TUNE_KEYS}
    with collecting(problems):
        tuning = tuning_of(graph, study=study, place=place, **given)
    if problems or tuning is None:
        raise ModelError(place.in_order(problems))
    return tuning


def _asks_study(table: dict[str, Any]) -> bool:
    goals = table.get("goals")
    entries = goals.values() if isinstance(goals, dict) else ()
    return "ages" in table or any(isinstance(goal, dict) and "yield" in goal for goal in entries)
