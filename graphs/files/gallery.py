"""The gallery: what each graph of the packaged library is, by its folder, name and description."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from proofmass.blocks.declaration.problem import Problem, did_you_mean
from proofmass.graphs.files.library import FOLDER, library_file, library_files
from proofmass.graphs.files.toml_reader import read_table

PARTS = "parts"  # folder of graphs that other graphs have as blocks
TEMPLATE = "template.toml"


@dataclass(frozen=True)
class Exhibit:
    """A graph or a study of the library."""

    name: str  # of its file, without the ending
    family: str  # the folder
    title: str
    description: str
    path: Path
    beside: tuple[str, ...]  # files of the library that it names as beside it
    study: bool  # whether it is a study of a graph beside it


@cache
def exhibits() -> tuple[Exhibit, ...]:
    """Return all graphs and studies of the library by family and name."""
    files = (path for name, path in library_files().items() if path.suffix == ".toml" and name != TEMPLATE)
    return tuple(sorted(map(exhibit_of, files), key=lambda one: (one.family == PARTS, one.family, one.name)))


def exhibit(name: str) -> Exhibit:
    """Return the exhibit of a name, with or without ending; raises `ModelError`."""
    wanted = name.removesuffix(".toml")
    for one in exhibits():
        if one.name == wanted:
            return one
    hint = did_you_mean(wanted, [one.name for one in exhibits()], "the graphs of `proofmass gallery`")
    raise Problem(message="the gallery has no such graph", key=name, hint=hint).error


def exhibit_of(path: Path) -> Exhibit:
    """Return what the file of a graph or study of the library is."""
    table, _ = read_table(path)
    beside = tuple(dict.fromkeys(_beside(table)))
    studied = next((name for name in beside if name.endswith(".toml")), None)
    title = table.get("name") or (f"a study of {Path(studied).stem}" if studied else path.stem)
    description = " ".join(str(table.get("description", "")).split())
    family = path.parent.name if path.parent != FOLDER else ""
    return Exhibit(path.stem, family, str(title), description, path, beside, studied is not None)


def _beside(table: dict[str, object]) -> Iterator[str]:
    """Files that a graph or study names in its own folder, those that these name included."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _beside(value)
        elif key in ("graph", "file") and isinstance(value, str) and value in library_files():
            yield value
            if value.endswith(".toml"):
                yield from _beside(read_table(library_file(value))[0])
