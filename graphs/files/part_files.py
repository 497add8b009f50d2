"""Files of subgraphs: each read once, from the graph's folder or the library, without cycles."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from proofmass.blocks.declaration.problem import ModelError, Refusal, did_you_mean, shown
from proofmass.graphs.files.library import LIBRARY, library_files
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.limits import ALL_FILES_BYTES, DEPTH, TEXT_LENGTH


class PartFiles:
    """Files by their place on disk, with the chain of those that are being read."""

    def __init__(self, read: "Callable[[Path, PartFiles, int], Graph]", first: Path | None = None) -> None:
        self._read = read
        self._known: dict[Path, Graph | ModelError] = {}
        self._chain: dict[Path, str] = {}
        self._bytes = 0
        if first is not None:
            with suppress(OSError, RuntimeError, ValueError):  # its reading reports problems
                self._chain[first.resolve()] = first.name

    def graph(self, name: object, folder: str, depth: int) -> Graph:
        """Return the graph of a file named in another; raises `Refusal`, or `ModelError` for problems inside it."""
        path = file_inside(name, folder)
        place = path.resolve()
        if place in self._chain:
            chain = [*self._chain.values(), path.name]
            raise Refusal(f"the file contains itself: {' -> '.join(chain)}", "take one of these steps out")
        if place not in self._known:
            self._bytes += path.stat().st_size
            if self._bytes > ALL_FILES_BYTES:
                raise Refusal(f"the files of the graph are larger than {ALL_FILES_BYTES >> 20} MiB together")
            if depth > DEPTH:
                raise Refusal(f"subgraphs nested deeper than {DEPTH} levels")
            self._chain[place] = path.name
            try:
                self._known[place] = self._read(path, self, depth)
            except ModelError as error:
                self._known[place] = error
            del self._chain[place]
        known = self._known[place]
        if isinstance(known, ModelError):
            raise known
        return known


def file_inside(name: object, folder: str) -> Path:
    """The path of a file that may be read: inside the folder or below it, or of the library."""
    if not isinstance(name, str) or not name or len(name) > TEXT_LENGTH or not name.isprintable():
        raise Refusal("must be the name of a file", "files are named in quotes, relative to the folder of this one")
    if name.startswith(LIBRARY):
        return _of_the_library(name.removeprefix(LIBRARY))
    base = Path(folder)
    path = base / name
    hint = "put it into the folder of this file, or into one below"
    try:
        if Path(name).is_absolute() or not path.resolve().is_relative_to(base.resolve()):
            raise Refusal("the file lies outside the folder of this one", hint)
        if path.is_file():
            return path
        there = path.exists()
    except (OSError, RuntimeError) as error:
        raise Refusal(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if there:
        raise Refusal("is not a file", hint)
    raise Refusal(f"there is no file {shown(path.name)[1:-1]}", _near(path))


def _of_the_library(name: str) -> Path:
    files = library_files()
    if name in files:
        return files[name]
    hint = did_you_mean(name, [file for file in files if file.endswith(".toml")], "the files of the library")
    raise Refusal(f"the library has no file {shown(name)[1:-1]}", hint)


def _near(path: Path) -> str:
    try:
        names = [other.name for other in path.parent.iterdir() if other.suffix == (path.suffix or ".toml")]
    except OSError:
        return "there is no such folder"
    return did_you_mean(path.name, names, "the files there")
