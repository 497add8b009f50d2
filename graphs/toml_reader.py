"""A graph from a TOML file, with the line of every problem. Nothing in the file is evaluated, imported or fetched."""

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from proofmass.blocks.catalog import Own, all_blocks, find
from proofmass.blocks.declare import Block
from proofmass.blocks.problem import ModelError, Problem, did_you_mean, shown
from proofmass.graphs.graph import Graph, Place
from proofmass.graphs.limits import FILE_BYTES
from proofmass.graphs.locate_keys import LimitError, locate_keys

TOP_KEYS = ("name", "description", "rate", "duration", "samples", "seed", "wires", "probes", "blocks")
_PLAIN = ("rate", "duration", "samples", "seed")


def read_graph(path: str | Path, own: Own | None = None) -> Graph:
    """The graph of a file; `own` are the caller's own blocks by name.

    Raises `ModelError` with every problem that can be seen, each with file, line and key.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            data = file.read(FILE_BYTES + 1)
    except OSError as error:
        raise ModelError([Problem(message=f"cannot be read: {error.strerror}", file=str(path))]) from None
    return read_graph_text(_decoded(data, str(path)), str(path), own, str(path.parent))


def read_graph_text(text: str, file: str = "<text>", own: Own | None = None, folder: str = ".") -> Graph:
    """The graph of a TOML text; file names in it start from `folder`."""
    data, place = _parsed(text, file, folder)
    problems = [
        Problem(message="unknown key", key=key, got=shown(key), hint=_unknown_hint(key), path=(key,))
        for key in data
        if key not in TOP_KEYS
    ]
    blocks, rates = _blocks(data.get("blocks", {}), own, problems)
    given = {key: data[key] for key in _PLAIN if key in data}
    for key in ("wires", "probes"):
        value = data.get(key, [])
        if not isinstance(value, list):
            problems.append(Problem(message="must be a list", key=key, got=shown(value), path=(key,)))
            value = []
        given[key] = value
    for key in ("name", "description"):
        value = data.get(key, "")
        if not isinstance(value, str) or len(value) > 10_000:
            problems.append(Problem(message="must be a string", key=key, got=shown(value), path=(key,)))
            value = ""
        given[key] = value
    if isinstance(given["wires"], list):
        place = _with_wire_lines(place, given["wires"])
    try:
        graph = Graph(blocks=blocks, rates=rates, place=place, **given)
    except ModelError as error:
        problems += error.problems
        graph = None
    if problems or graph is None:
        placed = {p.at(file, place.line(p.path)): None for p in problems}
        raise ModelError(sorted(placed, key=lambda p: p.line))
    return graph


def _decoded(data: bytes, file: str) -> str:
    def refuse(message: str, line: int = 0, hint: str = "") -> ModelError:
        return ModelError([Problem(message=message, file=file, line=line, hint=hint)])

    if len(data) > FILE_BYTES:
        raise refuse(f"larger than {FILE_BYTES // 1024} KiB", hint="put recorded data into a file of its own")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise refuse("not UTF-8 text", data.count(b"\n", 0, error.start) + 1, "save the file as UTF-8") from None
    if "\0" in text:
        raise refuse("holds a NUL character", text.count("\n", 0, text.index("\0")) + 1, "save it as plain text")
    return text.removeprefix("\ufeff").replace("\r\n", "\n")


def _parsed(text: str, file: str, folder: str) -> tuple[dict[str, Any], Place]:
    try:
        lines = locate_keys(text)
    except LimitError as error:
        raise ModelError([Problem(message=str(error), file=file, line=error.line)]) from None
    try:
        return tomllib.loads(text), Place(file, lines, folder)
    except (ValueError, RecursionError) as error:
        message, line = str(error), 0
        if "(at line " in message:
            message, _, rest = message.partition(" (at line ")
            line = int(rest.partition(",")[0])
        hint = _syntax_hint(text.splitlines()[line - 1] if 0 < line <= text.count("\n") + 1 else "")
        raise ModelError([Problem(message=f"not TOML: {message}", file=file, line=line, hint=hint)]) from None


def _syntax_hint(line: str) -> str:
    value = line.partition("=")[2].strip()
    if value and value[0].isdigit() and any(c.isalpha() for c in value):
        return f'a number with a unit is a string: {line.partition("=")[0].strip()} = "{value}"'
    return ""


def _unknown_hint(key: str) -> str:
    return did_you_mean(key, TOP_KEYS, "key")


def _blocks(tables: Any, own: Own | None, problems: list[Problem]) -> tuple[dict[str, Block], dict[str, Any]]:
    blocks: dict[str, Block] = {}
    rates: dict[str, Any] = {}
    if not isinstance(tables, dict):
        problems.append(Problem(message="must be a table", key="blocks", got=shown(tables), path=("blocks",)))
        return blocks, rates
    for name, table in tables.items():
        key, path = f"blocks.{name}", ("blocks", name)
        if not isinstance(table, dict) or not isinstance(table.get("kind"), str):
            hint = f'write [{key}] and below it kind = "Gain"'
            problems.append(Problem(message="a block needs a kind", key=key, got=shown(table), hint=hint, path=path))
            continue
        kind = find(table["kind"], own)
        if kind is None:
            hint = did_you_mean(table["kind"], all_blocks(own), "kind")
            problems.append(
                Problem(
                    message="there is no such kind of block",
                    key=f"{key}.kind",
                    got=shown(table["kind"]),
                    hint=hint + "; `proofmass blocks` lists them",
                    path=(*path, "kind"),
                )
            )
            continue
        if "rate" in table:
            rates[name] = table["rate"]
        values = {k: v for k, v in table.items() if k not in ("kind", "rate")}
        try:
            blocks[name] = kind(**values)
        except ModelError as error:
            for problem in error.problems:
                problems.append(_of_block(problem, name, values))
            blocks[name] = kind()
    return blocks, rates


def _of_block(problem: Problem, name: str, values: Mapping[str, Any]) -> Problem:
    parameter = problem.path[0]
    hint = problem.hint
    if parameter in TOP_KEYS and isinstance(values.get(parameter), list):
        hint = f"keys after [blocks.{name}] belong to that block: put {parameter} above the first [blocks. ...]"
    return replace(problem, key=f"blocks.{name}.{parameter}", path=("blocks", name, parameter), hint=hint)


def _with_wire_lines(place: Place, wires: list[Any]) -> Place:
    """Lines of wires by their text, since a graph keeps them sorted."""
    lines = dict(place.lines)
    for index, text in enumerate(wires):
        if isinstance(text, str) and text.count("->") == 1:
            normal = " -> ".join(end.strip() for end in text.split("->"))
            lines.setdefault(("wires", normal), place.line(("wires", str(index))))
    return Place(place.file, lines, place.folder)
