"""The packaged library of graphs: each file found by its name alone, which no two of its folders share."""

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


def library_path(text: str) -> Path | None:
    """Return the file that `library:NAME` names, with `.toml` or without; None where there is none.

    >>> library_path("library:closed_loop_accelerometer").name
    'closed_loop_accelerometer.toml'
    """
    name, files = text.removeprefix(LIBRARY), library_files()
    return files.get(name) or files.get(f"{name}.toml")


def library_file(name: str) -> Path:
    """Return the file of a name; raises KeyError where the library has none."""
    return library_files()[name]
