"""Two graph files compared by meaning: their graphs, the variants of their studies, and what they are tuned for."""

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path

from proofmass.blocks.declaration.catalog import Own
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph, read_table
from proofmass.graphs.files.toml_writer import inline
from proofmass.graphs.model.differences import GraphDifference, changed_entries, differences
from proofmass.graphs.model.flatten import FlatGraph, flatten
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import STUDY, is_study, read_variants
from proofmass.graphs.tuning.reader import TUNE, read_tuning
from proofmass.runner.comparison.studies import study_differences
from proofmass.runner.plan.recording import read_recordings

THERE = "there"


def file_differences(before: Path, after: Path, own: Own | None) -> list[GraphDifference]:
    """Return the differences of two graph or study files; raises `ModelError`."""
    tables = [read_table(path)[0] for path in (before, after)]
    studied = [is_study(table) or STUDY in table for table in tables]
    if all(studied):
        found = list(_variants(*(read_variants(path, own) for path in (before, after))))
    else:
        graphs = [_graph(path, own, is_study(table)) for path, table in zip((before, after), tables, strict=True)]
        found = [*_differences(graphs[0], graphs[1]), *_only_one(STUDY, studied)]
    tuned = [TUNE in table and not is_study(table) for table in tables]
    if all(tuned):
        return [*found, *changed_entries("", *(_lines(path, own) for path in (before, after)))]
    return [*found, *_only_one(TUNE, tuned)]


def _graph(path: Path, own: Own | None, study: bool) -> Graph:
    return next(iter(read_variants(path, own).values())).graph if study else read_graph(path, own)


def _differences(first: Graph, second: Graph) -> list[GraphDifference]:
    """Return the differences of two graphs, and of what recordings of one name hold."""
    flats = flatten(first), flatten(second)
    blocks = [flat.blocks for flat in flats]
    same = [name for name in blocks[0] if name in blocks[1] and _names(blocks[0][name]) == _names(blocks[1][name])]
    held = [{f"{name}.file": _held(flat, name) for name in same} for flat in flats]
    return [*differences(first, second), *changed_entries("blocks.", *held)]


def _names(block: Block) -> tuple[object, ...]:
    return type(block), getattr(block, "file", ""), getattr(block, "column", "")


def _held(flat: FlatGraph, name: str) -> str:
    """Return the file of a recording and the check sum of its numbers, or why it has none; "" of other blocks."""
    try:
        played = sorted(read_recordings(flat, name).items())
    except ModelError as error:
        return error.problems[0].message
    digest = hashlib.sha256(repr(played).encode()).hexdigest()
    return f"{getattr(flat.blocks[name], 'file', '')}, numbers {digest[:12]}" if played else ""


def _only_one(key: str, there: list[bool]) -> Iterator[GraphDifference]:
    if there[0] != there[1]:
        yield GraphDifference(key, *(THERE if one else "" for one in there))


def _variants(first: Mapping[str, Study], second: Mapping[str, Study]) -> Iterator[GraphDifference]:
    """Yield what all variants differ by once, then what each of them differs by, below its name."""
    both = [name for name in first if name in second]
    apart = {n: [*_differences(first[n].graph, second[n].graph), *study_differences(first[n], second[n])] for n in both}
    if not both:  # without common variants the first of each are compared
        one, other = (next(iter(studies.values())) for studies in (first, second))
        apart = {"": [*_differences(one.graph, other.graph), *study_differences(one, other)]}
    of_all = [d for d in next(iter(apart.values())) if all(d in others for others in apart.values())]
    yield from of_all
    for name, own in apart.items():
        place = f"study.variants.{name}." if name else ""
        yield from (GraphDifference(place + d.key, d.before, d.after, d.follows) for d in own if d not in of_all)
    for name in sorted((first.keys() ^ second.keys()) - {""}):
        yield GraphDifference(f"study.variants.{name}", THERE if name in first else "", THERE if name in second else "")


def _lines(path: Path, own: Own | None) -> dict[str, str]:
    """Return the entries of `[tune]` by their keys, as text."""
    tables = read_tuning(path, own).as_tables()
    keys = {name: ".".join(filter(None, (TUNE, name))) for name in tables}
    return {f"{keys[name]}.{key}": inline(entry) for name, table in tables.items() for key, entry in table.items()}
