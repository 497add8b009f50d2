"""A graph from a TOML file, with the line of every problem. Nothing in the file is evaluated, imported or fetched."""

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from proofmass.blocks.catalog import Own, all_blocks, find
from proofmass.blocks.declare import Block
from proofmass.blocks.problem import ModelError, Problem, nearest, shown
from proofmass.graphs.graph import Graph, Place
from proofmass.graphs.hints import like, syntax_hint
from proofmass.graphs.limits import FILE_BYTES, PROBLEMS, TEXT_LENGTH
from proofmass.graphs.locate_keys import LimitError, locate_keys

TOP_KEYS = {
    "name": "Name of the graph, in plots and reports.",
    "description": "What the graph is, in a few lines.",
    "rate": 'Rate of every block that has none of its own: "50 kHz", or the period "20 us", or a number in hertz.',
    "duration": 'How long a run lasts when nothing else is said: "20 s", or a number in seconds.',
    "samples": "How many ticks of the base rate a run lasts, instead of a duration.",
    "seed": "Seed of the noise when nothing else is said.",
    "wires": 'Wires, "block.output -> block.input"; a wire to a parameter drives the parameter.',
    "probes": 'Outputs to record, "block.output"; { signal = "block.output", every = 10 } keeps one value in ten.',
    "blocks": "The blocks: [blocks.NAME] with a kind and the parameters of that kind.",
}
BLOCK_KEYS = {  # of every block, beside its parameters
    "kind": "Kind of the block; `proofmass blocks` lists them.",
    "rate": "Rate of this block, where it differs from the graph's.",
}


def read_graph(path: str | Path, own: Own | None = None) -> Graph:
    """The graph of a file; `own` are the caller's own blocks by name.

    Raises `ModelError` with every problem that can be seen, each with file, line and key.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            data = file.read(FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ModelError([Problem(message=f"cannot be read: {reason}", file=str(path))]) from None
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        if len(data) > FILE_BYTES:
            raise _too_large(str(path)) from None
        line = data.count(b"\n", 0, error.start) + 1
        raise _refused(str(path), line, "not UTF-8 text", "save the file as UTF-8") from None
    return read_graph_text(text, str(path), own, str(path.parent))


def read_graph_text(text: str, file: str = "<text>", own: Own | None = None, folder: str = ".") -> Graph:
    """The graph of a TOML text; file names in it start from `folder`."""
    data, place = _parsed(text, file, folder)
    problems = [
        Problem(message="unknown key", key=key, got=shown(key), hint=like(key, TOP_KEYS, "the keys"), path=(key,))
        for key in data
        if key not in TOP_KEYS
    ]
    reader = _Blocks(own)
    reader.read(data.get("blocks", {}))
    given = {"name": "", **{key: value for key, value in data.items() if key in TOP_KEYS and key != "blocks"}}
    for key in ("wires", "probes"):
        if not isinstance(given.get(key, []), list):
            got, hint = shown(given.pop(key)), f"{key} is a list of texts in square brackets"
            problems.append(Problem(message="must be a list", key=key, got=got, hint=hint, path=(key,)))
    place = _with_wire_lines(place, given.get("wires", []))
    graph = None
    try:
        graph = Graph(blocks=reader.blocks, rates=reader.rates, place=place, **given)
    except ModelError as error:
        problems += error.problems
    if graph is not None and not problems and reader.problems:
        from proofmass.graphs.check import check_apart_from

        problems += check_apart_from(graph, reader.doubtful)
    problems += reader.problems
    if problems or graph is None:
        raise ModelError(_in_order(problems, place))
    return graph


def _parsed(text: str, file: str, folder: str) -> tuple[dict[str, Any], Place]:
    if len(text) > FILE_BYTES or len(text.encode("utf-8", "surrogatepass")) > FILE_BYTES:
        raise _too_large(file)
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise _refused(file, line, "holds a NUL character", "save it as plain text")
    text = text.removeprefix("\ufeff").replace("\r\n", "\n")
    try:
        lines = locate_keys(text)  # first: it refuses what the parser would take minutes for
        return tomllib.loads(text), Place(file, lines, folder)
    except LimitError as error:
        raise _refused(file, error.line, str(error)) from None
    except (ValueError, RecursionError) as error:
        message, _, place = str(error).partition(" (at ")
        texts = text.rstrip("\n").split("\n")
        word, _, rest = place.partition(" ")
        line = int(rest.partition(",")[0]) if word == "line" else len(texts)
        hint = syntax_hint(message, texts[line - 1] if line <= len(texts) else "")
        raise _refused(file, line, f"not TOML: {message}", hint) from None


def _refused(file: str, line: int, message: str, hint: str = "") -> ModelError:
    return ModelError([Problem(message=message, file=file, line=line, hint=hint)])


def _too_large(file: str) -> ModelError:
    return _refused(file, 0, f"larger than {FILE_BYTES >> 10} KiB", "put recorded data into a file of its own")


def _in_order(problems: list[Problem], place: Place) -> list[Problem]:
    """Each problem once, with its place, in the order of the file."""
    placed = dict.fromkeys(problem.at(place.file, place.line(problem.path)) for problem in problems)
    ordered = sorted(placed, key=lambda problem: problem.line)
    more = len(ordered) - PROBLEMS
    if more <= 0:
        return ordered
    return [*ordered[:PROBLEMS], Problem(message="and more problems", file=place.file, line=ordered[PROBLEMS].line)]


class _Blocks:
    """The blocks of a file; those with problems are `doubtful` and stand with the parameters of their kind."""

    def __init__(self, own: Own | None) -> None:
        self.own = own
        self.kinds: dict[str, type[Block] | None] = {}
        self.blocks: dict[str, Block] = {}
        self.rates: dict[str, Any] = {}
        self.doubtful: set[str] = set()
        self.problems: list[Problem] = []

    def read(self, tables: object) -> None:
        if not isinstance(tables, dict):
            hint = "write a table for each block: [blocks.NAME] and below it its kind"
            self._refuse(Problem(message="must be a table", key="blocks", got=shown(tables), hint=hint), "blocks")
            return
        for name, table in tables.items():
            if len(self.problems) > PROBLEMS:
                return
            kind = self._kind(name, table)
            if kind is None:
                self.doubtful.add(name)
                continue
            values = {key: value for key, value in table.items() if key not in BLOCK_KEYS}
            try:
                self.blocks[name] = _block(kind, name, values)
            except ModelError as error:
                self.doubtful.add(name)
                self.problems += error.problems
                try:
                    self.blocks[name] = kind()
                except ModelError:
                    continue
            if "rate" in table:
                self.rates[name] = table["rate"]

    def _refuse(self, problem: Problem, *path: str) -> None:
        self.problems.append(replace(problem, path=path))

    def _kind(self, name: str, table: object) -> type[Block] | None:
        key, path = f"blocks.{name}", ("blocks", name)
        if not isinstance(table, dict) or "kind" not in table:
            meant = nearest("kind", table) if isinstance(table, dict) else ""
            hint = f"did you mean kind instead of {meant}?" if meant else f'write [{key}] and below it kind = "Gain"'
            self._refuse(Problem(message="a block needs a kind", key=key, got=shown(table), hint=hint), *path)
            return None
        kind = table["kind"]
        if not isinstance(kind, str):
            hint = 'write it in quotes, such as kind = "Gain"'
            problem = Problem(message="must be a string", key=f"{key}.kind", got=shown(kind), hint=hint)
            self._refuse(problem, *path, "kind")
            return None
        if kind not in self.kinds:
            self.kinds[kind] = find(kind, self.own) if len(kind) <= TEXT_LENGTH else None
        if self.kinds[kind] is None:
            hint = like(kind[:TEXT_LENGTH], all_blocks(self.own), "the kinds") + " `proofmass blocks` shows them all"
            message = "there is no such kind of block"
            self._refuse(Problem(message=message, key=f"{key}.kind", got=shown(kind), hint=hint), *path, "kind")
        return self.kinds[kind]


def _block(kind: type[Block], name: str, values: Mapping[str, Any]) -> Block:
    """The block of a table; its problems speak of the file's keys."""
    path = ("blocks", name)
    long = [key for key, value in values.items() if _has_long_text(value)]
    if long:
        message = f"a text of over {TEXT_LENGTH} characters"
        raise ModelError([Problem(message=message, key=".".join((*path, key)), path=(*path, key)) for key in long])
    problems = [_unknown(kind, name, key) for key in values if key not in kind.parameters]
    made = None
    try:
        made = kind(**{key: value for key, value in values.items() if key in kind.parameters})
    except ModelError as error:
        for problem in error.problems:
            where = (*path, *problem.path)
            problems.append(replace(problem, key=".".join(where), path=where))
    except (ArithmeticError, ValueError) as error:
        problems.append(Problem(message=f"its parameters cannot be read: {error}", key=f"blocks.{name}", path=path))
    if problems or made is None:
        raise ModelError(problems)
    return made


def _has_long_text(value: object) -> bool:
    entries = value if isinstance(value, list) else [value]
    return any(isinstance(entry, str) and len(entry) > TEXT_LENGTH for entry in entries)


def _unknown(kind: type[Block], name: str, key: str) -> Problem:
    """A key of a block that is no parameter of its kind: misspelt, misplaced, or a port."""
    if key in TOP_KEYS:
        hint = f"after [blocks.{name}] it belongs to that block: move it above the first [blocks. ...]"
    elif key in kind.inputs:
        hint = f'{key} is an input: connect it in wires, as in "block.output -> {name}.{key}"'
    elif key in kind.outputs:
        hint = f'{key} is an output: record it in probes, as in "{name}.{key}"'
    else:
        hint = like(key, [*kind.parameters, *BLOCK_KEYS], f"the parameters of {kind.__name__}")
    path = ("blocks", name, key)
    message = f"{kind.__name__} has no such parameter"
    return Problem(message=message, key=".".join(path), got=shown(key), hint=hint, path=path)


def _with_wire_lines(place: Place, wires: list[Any]) -> Place:
    """Lines of wires by their text, since a graph keeps them sorted."""
    lines = dict(place.lines)
    for index, text in enumerate(wires):
        if isinstance(text, str) and text.count("->") == 1:
            normal = " -> ".join(end.strip() for end in text.split("->"))
            lines.setdefault(("wires", normal), place.line(("wires", str(index))))
    return Place(place.file, lines, place.folder)
