"""The packaged library of graphs: each file is found by its name alone."""

from functools import cache
from pathlib import Path

LIBRARY = "library:"  # before the name of a file of the packaged library
FOLDER = Path(__file__).parents[1] / "library"


@cache
def library_files() -> dict[str, Path]:
    """Return the files of the library by their names, in alphabetical order.

    >>> library_files()["closed_loop_accelerometer.toml"].parent.name
    'accelerometer'
    """
    files = (file for file in FOLDER.rglob("*") if file.suffix in (".toml", ".csv"))
    return {file.name: file for file in sorted(files, key=lambda file: file.name)}


def library_file(name: str) -> Path:
    """Return the file of a name; raises KeyError where the library has none."""
    return library_files()[name]


def file_of(name: str | Path) -> Path:
    """Return the file of a path, or of the library for "library:NAME", whose `.toml` may be left out.

    >>> file_of("library:closed_loop_accelerometer").name
    'closed_loop_accelerometer.toml'
    """
    if not str(name).startswith(LIBRARY):
        return Path(name)
    wanted = str(name).removeprefix(LIBRARY)
    files = library_files()
    return files.get(wanted) or files.get(f"{wanted}.toml") or Path(name)
