"""Edit parameters of a graph file in place: comments, order and layout of all else stay."""

import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.files.locate_keys import locate_keys
from proofmass.graphs.files.toml_writer import quoted
from proofmass.graphs.model.graph import split

_VALUE = r"""(?:"(?:[^"\\]|\\.)*"|'[^']*'|[^"'\[{#\s][^"'\[{#\n]*?)"""


def edited(text: str, changes: Mapping[str, float | int | str], file: str = "<text>") -> str:
    """The text of a graph file with parameters and values set: numbers, true or false, or strings with a unit.

    They are named as in the file: `block.parameter`, `part.exported` or `part.block.parameter` of a
    graph that is a block, or the name of a value. The block must have a table of its own,
    `[blocks.NAME]`. A parameter that is not there yet comes after the last that is.
    Raises `ModelError`, with the line, where a parameter is written in a way that cannot be edited.
    """
    lines = text.split("\n")
    tables = tomllib.loads(text)
    for key, value in changes.items():
        path = _path(tables, key)
        number = str(value).lower() if isinstance(value, bool | int | str) else repr(float(value))
        written = quoted(value) if isinstance(value, str) else number
        table = tables
        for step in path[:-1]:
            if not isinstance(table.get(step), dict):
                raise _refused(file, 0, key).error
            table = table[step]
        _set(lines, path, written, file)
        table[path[-1]] = value
    result = "\n".join(lines)
    with suppress(tomllib.TOMLDecodeError):
        if tomllib.loads(result) == tables:
            return result
    hint = "write every parameter on its own line"
    raise Problem(message="cannot be edited in place", file=file, hint=hint).error


def _path(data: Mapping[str, Any], key: str) -> tuple[str, ...]:
    """Keys of a name in the file: in `[values]`, its block's table, or a subgraph's."""
    block, parameter = split(key)
    if not block:
        named = data.get("exports", {}).get(key, key)
        return _path(data, named) if named != key else ("values", key)
    if block in data.get("blocks", {}):
        return "blocks", block, parameter
    head, _, inner = key.partition(".")
    return "blocks", head, inner


def edit_file(path: Path, changes: Mapping[str, float | str]) -> str:
    """Return the text of a file with parameters set; write nothing."""
    with path.open(encoding="utf-8", newline="") as file:
        return edited(file.read(), changes, str(path))


def _set(lines: list[str], path: tuple[str, ...], written: str, file: str) -> None:
    places = locate_keys("\n".join(lines))
    table, parameter = path[:-1], f'"{path[-1]}"' if "." in path[-1] else path[-1]
    line = places.get(path, 0)
    if line:
        form = rf"(\s*\"?{re.escape(path[-1])}\"?\s*=\s*){_VALUE}(\s*(?:#.*)?)"
        found = re.fullmatch(form, lines[line - 1], re.DOTALL)
        if found is None:
            raise _refused(file, line, ".".join(path)).error
        lines[line - 1] = found[1] + written + found[2]
        return
    head = places.get(table, 0)
    form = r"\s*\.\s*".join(map(re.escape, table))
    if not re.match(rf"\s*\[\s*{form}\s*\]", lines[head - 1] if head else ""):
        raise _refused(file, head, ".".join(table)).error
    last = max(place for known, place in places.items() if known[: len(table)] == table)
    ending = "\r" if lines[last - 1].endswith("\r") else ""
    lines.insert(last, f"{parameter} = {written}{ending}")


def _refused(file: str, line: int, key: str) -> Problem:
    hint = "write the block as a table of its own, one parameter a line"
    return Problem(message="cannot be edited in place", file=file, line=line, key=key, hint=hint)
