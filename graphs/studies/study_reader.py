"""A study from a TOML file: one names its graph, or a graph file with a table `[study]` in it."""

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.catalog import Own
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal
from proofmass.graphs.files.library import file_of
from proofmass.graphs.files.part_files import PartFiles
from proofmass.graphs.files.toml_reader import graph_of_file, parsed, read_graph, read_table
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph, Place
from proofmass.graphs.model.keys import STUDY_KEYS
from proofmass.graphs.model.limits import PROBLEMS
from proofmass.graphs.model.top_keys import TOP_KEYS
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.table_entries import unknown_keys
from proofmass.graphs.studies.variants import variants_of

STUDY = "study"
GraphChange = Callable[[Graph], Graph]  # of the graph of a study, before its study is read


def unchanged(graph: Graph) -> Graph:
    """Return the graph itself."""
    return graph


def read_study(path: str | Path, own: Own | None = None, change: GraphChange = unchanged) -> Study:
    """The study of a file, of variants the first.

    Raises `ModelError` with every problem that can be seen, each with file, line and key.

    `path` is a file, or "library:NAME". `own` are the caller's own blocks by name; the study is that of
    its graph after a `change`.

    >>> from proofmass import read_study
    >>> study = read_study("library:scale_factor_drift")
    >>> study.runs, len(study.epochs), list(study.limits)
    (200, 6, ['scale_factor', 'noise'])
    """
    return next(iter(read_variants(path, own, change).values()))


def read_variants(path: str | Path, own: Own | None = None, change: GraphChange = unchanged) -> dict[str, Study]:
    """The variants of the study of a file by name; one without a name if there are none.

    Raises `ModelError` with every problem that can be seen, each with file, line and key.

    `path` is a file, or "library:NAME". `own` are the caller's own blocks by name; the studies are
    those of its graph after a `change`.

    >>> from proofmass import read_variants
    >>> list(read_variants("library:scale_factor_drift"))
    ['']
    """
    path = file_of(path)
    data, place = read_table(path)
    return studies_of_table(data, place, change(graph_in(data, place, own, path)))


def only_study(studies: Mapping[str, Study]) -> Study:
    """Return the study that there is; raises `ModelError` of variants, each of which is a study of its own."""
    first, *others = studies.values()
    if others:
        hint = "take one of read_variants(FILE), or write a study without variants"
        message = "the study has variants, each of which is a study of its own"
        raise first.placed(Problem(message=message, got=", ".join(studies), hint=hint)).error
    return first


def read_study_text(text: str, file: str = "<text>", own: Own | None = None, folder: str = ".") -> Study:
    """The study of a TOML text; file names in it start from `folder`."""
    data, place = parsed(text, file, folder)
    return study_of_table(data, place, graph_in(data, place, own, None))


def graph_in(data: dict[str, Any], place: Place, own: Own | None, path: Path | None) -> Graph:
    """Return the graph of a parsed file, or that which its study names; raises `ModelError`."""
    return graph_of_study(data, place, own) if is_study(data) else graph_of_file(data, place, own, path)


def is_study(data: dict[str, Any]) -> bool:
    """Return whether a parsed file is a study that names its graph; otherwise it is a graph."""
    return "blocks" not in data and not data.keys().isdisjoint(STUDY_KEYS.keys() - TOP_KEYS.keys())


def graph_of_study(data: dict[str, Any], place: Place, own: Own | None) -> Graph:
    """The graph that a parsed study names; raises `ModelError`."""
    files = PartFiles(lambda part, _files, _depth: read_graph(part, own))
    if "graph" not in data:
        hint = 'add graph = "FILE.toml" at the top'
        raise Problem(message="the study names no graph", file=place.file, key="graph", hint=hint).error
    try:
        return files.graph(data["graph"], place.folder, 0)
    except Refusal as error:
        raise error.problem("graph", data["graph"]).at(*place.find(("graph",))).error from None


def study_of_table(data: dict[str, Any], place: Place, graph: Graph) -> Study:
    """The study in a parsed file, of its graph, the first of its variants; raises `ModelError`."""
    return next(iter(studies_of_table(data, place, graph).values()))


def studies_of_table(data: dict[str, Any], place: Place, graph: Graph) -> dict[str, Study]:
    """The variants of the study in a parsed file, of its graph; raises `ModelError`."""
    table: Any = data
    allowed = set(STUDY_KEYS)
    if not is_study(data):
        table, place = data.get(STUDY), dataclasses.replace(place, top=(STUDY,))
        allowed -= {"graph"}
    if not isinstance(table, dict):
        hint = 'add [study] and below it runs = 100, or write a file of its own: graph = "FILE.toml"'
        raise Problem(message="the graph has no study", file=place.file, key=STUDY, hint=hint).error
    problems = list(unknown_keys(table, allowed))
    given = {key: value for key, value in table.items() if key in allowed and key != "graph"}
    studies = dict[str, Study]()
    try:
        for name, variant in variants_of(given, graph).items():
            changed = with_parameters(graph, variant.parameters) if variant.parameters else graph
            studies[name] = Study(changed, place=place, **variant.tables)
    except ModelError as error:
        problems += error.problems
    except Refusal as error:
        got, expected, path = error.got, error.expected, tuple(error.key.split(".", 1))
        problems.append(Problem(message=str(error), got=got, expected=expected, hint=error.hint, path=path))
    if problems:
        raise ModelError(place.in_order(problems)[:PROBLEMS])
    return studies
