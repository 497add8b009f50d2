"""A study from a TOML file: one that names its graph, or a graph file with a table `[study]` in it."""

import dataclasses
from pathlib import Path
from typing import Any

from proofmass.blocks.catalog import Own
from proofmass.blocks.problem import ModelError, Problem, shown
from proofmass.graphs.graph import Graph, Place
from proofmass.graphs.hints import like
from proofmass.graphs.keys import STUDY_KEYS
from proofmass.graphs.limits import PROBLEMS
from proofmass.graphs.part_files import PartError, PartFiles
from proofmass.graphs.study import Study
from proofmass.graphs.toml_reader import graph_of_table, read_graph, read_table

STUDY = "study"


def read_study(path: str | Path, own: Own | None = None) -> Study:
    """The study of a file; raises `ModelError` with every problem that can be seen, each with file, line and key."""
    path = Path(path)
    data, place = read_table(path)
    if "blocks" not in data:
        return _study(data, place, own, None)
    files = PartFiles(lambda part, _files, _depth: read_graph(part, own), path)
    graph = graph_of_table(data, place, own, files, 0)
    if not isinstance(data.get(STUDY), dict):
        hint = 'add [study] and below it runs = 100, or write a file of its own: graph = "FILE.toml"'
        problem = Problem(message="the graph has no study", file=str(path), key=STUDY, hint=hint)
        raise ModelError([problem])
    return _study(data[STUDY], dataclasses.replace(place, top=(STUDY,)), own, graph)


def _study(table: dict[str, Any], place: Place, own: Own | None, graph: Graph | None) -> Study:
    problems = [
        Problem(message="unknown key", key=key, got=shown(key), hint=like(key, STUDY_KEYS, "the keys"), path=(key,))
        for key in table
        if key not in STUDY_KEYS or (key == "graph" and graph is not None)
    ]
    given = {key: value for key, value in table.items() if key in STUDY_KEYS and key != "graph"}
    study = None
    try:
        study = Study(graph or _graph(table, place, own), place=place, **given)
    except ModelError as error:
        problems += error.problems
    if problems or study is None:
        placed = [p if p.file else p.at(*place.find(p.path)) for p in problems]
        raise ModelError(sorted(placed, key=lambda p: (p.file != place.file, p.file, p.line))[:PROBLEMS])
    return study


def _graph(table: dict[str, Any], place: Place, own: Own | None) -> Graph:
    files = PartFiles(lambda part, _files, _depth: read_graph(part, own))
    if "graph" not in table:
        hint = 'add graph = "FILE.toml" at the top'
        raise ModelError([Problem(message="the study names no graph", key="graph", hint=hint)])
    try:
        return files.graph(table["graph"], place.folder, 0)
    except PartError as error:
        got = shown(table["graph"])
        raise ModelError(
            [Problem(message=str(error), key="graph", got=got, hint=error.hint, path=("graph",))]
        ) from None
