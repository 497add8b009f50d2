"""Parameters of a graph file changed in place: comments, order and layout of all else stay."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.locate_keys import locate_keys
from proofmass.graphs.model.graph import split

_VALUE = r"""(?:"(?:[^"\\]|\\.)*"|'[^']*'|[^"'\[{#\s][^"'\[{#\n]*?)"""


def edited(text: str, changes: Mapping[str, float | str], file: str = "<text>") -> str:
    """The text of a graph file with parameters set, by `block.parameter`: numbers, or strings with a unit.

    The block must have a table of its own, `[blocks.NAME]`. A parameter that is not there yet comes after the last
    that is. Raises `ModelError`, with the line, where a parameter is written in a way that cannot be edited.
    """
    lines = text.split("\n")
    tables = tomllib.loads(text)
    for key, value in changes.items():
        block, parameter = split(key)
        written = f'"{value}"' if isinstance(value, str) else repr(float(value))
        _set(lines, block, parameter, written, file)
        tables["blocks"][block][parameter] = value
    result = "\n".join(lines)
    if _parsed(result) != tables:
        problem = Problem(message="cannot be edited in place", file=file, hint="write every parameter on its own line")
        raise ModelError([problem])
    return result


def edit_file(path: Path, changes: Mapping[str, float | str]) -> str:
    """The text of a file with parameters set; nothing is written."""
    with path.open(encoding="utf-8", newline="") as file:
        return edited(file.read(), changes, str(path))


def _set(lines: list[str], block: str, parameter: str, written: str, file: str) -> None:
    places = locate_keys("\n".join(lines))
    table = ("blocks", block)
    line = places.get((*table, parameter), 0)
    if line:
        form = rf"(\s*{re.escape(parameter)}\s*=\s*){_VALUE}(\s*(?:#.*)?)"
        found = re.fullmatch(form, lines[line - 1], re.DOTALL)
        if found is None:
            raise ModelError([_refused(file, line, f"blocks.{block}.{parameter}")])
        lines[line - 1] = found[1] + written + found[2]
        return
    head = places.get(table, 0)
    if not re.match(rf"\s*\[\s*blocks\s*\.\s*{re.escape(block)}\s*\]", lines[head - 1] if head else ""):
        raise ModelError([_refused(file, head, f"blocks.{block}")])
    last = max(place for path, place in places.items() if path[:2] == table)
    ending = "\r" if lines[last - 1].endswith("\r") else ""
    lines.insert(last, f"{parameter} = {written}{ending}")


def _refused(file: str, line: int, key: str) -> Problem:
    hint = "write the block as a table of its own, one parameter a line"
    return Problem(message="cannot be edited in place", file=file, line=line, key=key, hint=hint)


def _parsed(text: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return None
