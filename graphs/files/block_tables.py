"""The tables of blocks in a graph file: blocks of a kind, and subgraphs from a file or from a table of their own."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any

from proofmass.blocks.declaration.catalog import Own, all_blocks, find
from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.other_names import kind_hint
from proofmass.blocks.declaration.parameter import fill
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, collecting, did_you_mean, nearest, shown
from proofmass.graphs.files.locate_keys import KeyPath
from proofmass.graphs.files.number_files import is_number_file, numbers_of_file
from proofmass.graphs.files.part_files import PartFiles
from proofmass.graphs.files.table_formulas import TableFormulas
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.changes import change_part
from proofmass.graphs.model.exports import ONE_INSIDE, exported, settable
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Place
from proofmass.graphs.model.keys import BLOCK_KEYS, PART_KEYS
from proofmass.graphs.model.limits import BLOCKS, DEPTH, PROBLEMS, TEXT_LENGTH
from proofmass.graphs.model.names import is_rate, is_value
from proofmass.graphs.model.targets import CLOCK_OFFSET
from proofmass.graphs.model.top_keys import TOP_KEYS


class BlockTables:
    """Reads the blocks of a file; those with problems are `doubtful` and have the default parameters of their kind."""

    def __init__(
        self,
        own: Own | None,
        place: Place,
        files: PartFiles,
        depth: int,
        read_table: Callable[[dict[str, Any], Place], Graph],
        formulas: TableFormulas,
    ) -> None:
        self.own, self.place, self.files, self.depth, self.read_table = own, place, files, depth, read_table
        self.formulas = formulas
        self.kinds: dict[str, type[Block] | None] = {}
        self.blocks: dict[str, Block | Graph] = {}
        self.rates: dict[str, Any] = {}
        self.offsets: dict[str, Any] = {}
        self.doubtful: set[str] = set()
        self.problems: list[Problem] = []
        self.inside = 0  # blocks of all subgraphs
        self.named = True  # whether the names of all blocks are known

    def read(self, tables: object) -> None:
        if not isinstance(tables, dict):
            hint = "write a table for each block: [blocks.NAME] and below it its kind"
            self._refuse("must be a table", "blocks", got=shown(tables), hint=hint)
            return
        for name, table in tables.items():
            if len(self.problems) > PROBLEMS or self.inside > BLOCKS:
                return
            if isinstance(table, dict) and "graph" in table:
                self._read_files(name, table, tables)
            elif isinstance(table, dict) and "kind" not in table and "blocks" in table:
                self._read_table(name, table)
            else:
                self._read_block(name, table)

    def _read_block(self, name: str, table: object) -> None:
        kind = self._kind(name, table)
        if kind is None or not isinstance(table, dict):
            self.doubtful.add(name)
            return
        values = {key: value for key, value in table.items() if key not in BLOCK_KEYS}
        try:
            values = self.formulas.of_block(kind, name, self._with_files(kind, name, values))
            self.blocks[name] = _block(kind, name, values)
        except ModelError as error:
            self.doubtful.add(name)
            self.problems += error.problems
            try:
                self.blocks[name] = kind()
            except ModelError:
                return
        if "rate" in table:
            self.rates[name] = table["rate"]
        if CLOCK_OFFSET in table:
            self.offsets[name] = table[CLOCK_OFFSET]

    def _with_files(self, kind: type[Block], name: str, table: Mapping[str, Any]) -> dict[str, Any]:
        """Return the table of a block with numbers in place of the files that hold them; raises `ModelError`."""
        numbers, problems = dict(table), list[Problem]()
        texts = {n: table.get(n, p.default) for n, p in kind.parameters.items() if p.kind is str}
        for key, entry in table.items():
            parameter = kind.parameters.get(key)
            if parameter is None or parameter.kind is not tuple or not is_number_file(entry):
                continue
            path = ("blocks", name, key)
            with collecting(problems, entry, path):
                numbers[key] = numbers_of_file(entry, self.place.folder, fill(parameter.unit, texts))
        if problems:
            raise ModelError(problems)
        return numbers

    def _read_table(self, name: str, table: dict[str, Any]) -> None:
        """Read a subgraph from a table of the file itself."""
        if self.depth >= DEPTH:
            self.doubtful.add(name)
            self._refuse(f"subgraphs nested deeper than {DEPTH} levels", "blocks", name)
            return
        try:
            inner = {key: value for key, value in table.items() if key != CLOCK_OFFSET}
            if CLOCK_OFFSET in table:
                self.offsets[name] = table[CLOCK_OFFSET]
            part = self.read_table(inner, replace(self.place, top=(*self.place.top, "blocks", name)))
            self._limit(name, part, 1)
            self.blocks[name] = part
        except ModelError as error:
            self.doubtful.add(name)
            for problem in error.problems:
                here = problem.file == self.place.file
                self.problems.append(replace(problem, key=f"blocks.{name}.{problem.key}") if here else problem)

    def _read_files(self, name: str, table: dict[str, Any], tables: Mapping[str, object]) -> None:
        """Read one or several subgraphs from another file."""
        path = ("blocks", name)
        names = list(self._names(name, table, tables))
        self.doubtful.update(names)
        if "kind" in table or "blocks" in table:
            other = "kind" if "kind" in table else "blocks"
            hint = "a block has a kind, or a graph from a file: remove one of them"
            self._refuse(f"has a graph and {other}", *path, hint=hint)
            return
        try:
            part = self.files.graph(table["graph"], self.place.folder, self.depth + 1)
            self._limit(name, part, len(names))
            part = self._changed(name, part, table, names)
        except Refusal as error:
            self.problems.append(replace(error.problem(f"blocks.{name}.graph", table["graph"]), path=(*path, "graph")))
            return
        except ModelError as error:
            self.problems += error.problems
            return
        for copy in names:
            self.doubtful.discard(copy)
            note_line(self.place, ("blocks", copy), path)
            if "rate" in table:
                note_line(self.place, ("blocks", copy, "rate"), (*path, "rate"))
                self.rates[copy] = table["rate"]
            if CLOCK_OFFSET in table:
                note_line(self.place, ("blocks", copy, CLOCK_OFFSET), (*path, CLOCK_OFFSET))
                self.offsets[copy] = table[CLOCK_OFFSET]
            self.blocks[copy] = part

    def _names(self, name: str, table: dict[str, Any], tables: Mapping[str, object]) -> Iterator[str]:
        count = table.get("count")
        if count is None:
            yield name
            return
        path = ("blocks", name, "count")
        if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= BLOCKS:
            self._refuse("must be a count", *path, got=shown(count), expected=f"an integer from 1 to {BLOCKS}")
            self.named = False
            return
        for number in range(1, count + 1):
            copy = f"{name}_{number}"
            if copy in tables:
                hint = f"rename [blocks.{copy}]: blocks.{name}.count makes {name}_1 to {name}_{count}"
                self._refuse("there is another block of that name", *path, got=copy, hint=hint)
            yield copy

    def _limit(self, name: str, part: Graph, count: int) -> None:
        self.inside += part.size.blocks * count
        if self.inside > BLOCKS:
            message, expected = "too many blocks with those inside the subgraphs", f"at most {BLOCKS}"
            raise Problem(message=message, got=str(self.inside), expected=expected, path=("blocks", name)).error

    def _changed(self, name: str, part: Graph, table: dict[str, Any], names: list[str]) -> Graph:
        """Return the subgraph with the values and parameters of its table."""
        values: dict[str, object] = {}
        paths: dict[str, KeyPath] = {}
        problems = []
        for path, value in _leaves({key: value for key, value in table.items() if key not in PART_KEYS}, ()):
            key, where = ".".join(path), ("blocks", name, *path)
            values[key], paths[key] = value, where
            if _has_long_text(value):
                problems.append(Problem(message=f"a text of over {TEXT_LENGTH} characters", path=where))
            elif len(path) == 1 and "." not in key and (hint := _misplaced(name, part, key, table)):
                message = "the subgraph exports no such parameter"
                problems.append(Problem(message=message, got=key, hint=hint, path=where))
        if problems:
            raise ModelError(problems)
        values = self.formulas.of_part(names, part, values)
        if not values:
            return part
        try:
            return change_part(part, values)
        except ModelError as error:
            own = [(p, paths.get(p.key, ("blocks", name))) for p in error.problems]
            raise ModelError([replace(p, key=f"blocks.{name}.{p.key}", path=path) for p, path in own]) from None

    def _refuse(self, message: str, *path: str, **more: Any) -> None:
        self.problems.append(Problem(message=message, path=path, **more))

    def _kind(self, name: str, table: object) -> type[Block] | None:
        path = ("blocks", name)
        if not isinstance(table, dict) or "kind" not in table:
            meant = nearest("kind", table) or nearest("graph", table) if isinstance(table, dict) else ""
            word = "kind" if meant and nearest("kind", [meant]) else "graph"
            other = f'write [blocks.{name}] and below it kind = "Gain"'
            hint = f"did you mean {word} instead of {meant}?" if meant else other
            self._refuse("a block needs a kind", *path, got=shown(table), hint=hint)
            return None
        kind = table["kind"]
        if not isinstance(kind, str):
            hint = 'write it in quotes, such as kind = "Gain"'
            self._refuse("must be a string", *path, "kind", got=shown(kind), hint=hint)
            return None
        if kind not in self.kinds:
            self.kinds[kind] = find(kind, self.own) if len(kind) <= TEXT_LENGTH else None
        if self.kinds[kind] is None:
            near = kind_hint(kind[:TEXT_LENGTH], all_blocks(self.own), bool(self.own))
            hint = f"{near} `proofmass blocks` lists all kinds."
            self._refuse("there is no such kind of block", *path, "kind", got=shown(kind), hint=hint)
        return self.kinds[kind]


def _block(kind: type[Block], name: str, values: Mapping[str, Any]) -> Block:
    """Read the block of a table; its problems name the file's keys."""
    path = ("blocks", name)
    long = [key for key, value in values.items() if _has_long_text(value)]
    if long:
        message = f"a text of over {TEXT_LENGTH} characters"
        raise ModelError([Problem(message=message, path=(*path, key)) for key in long])
    problems = [_unknown(kind, name, key, values) for key in values if key not in kind.parameters]
    block = None
    try:
        block = kind(**{key: value for key, value in values.items() if key in kind.parameters})
    except ModelError as error:
        for problem in error.problems:
            where = (*path, *problem.path)
            problems.append(replace(problem, key=".".join(where), path=where))
    except (ArithmeticError, ValueError) as error:
        problems.append(Problem(message=f"its parameters cannot be read: {error}", path=path))
    if problems or block is None:
        raise ModelError(problems)
    return block


def _has_long_text(value: object) -> bool:
    entries = value if isinstance(value, list) else [value]
    return any(isinstance(entry, str) and len(entry) > TEXT_LENGTH for entry in entries)


def _unknown(kind: type[Block], name: str, key: str, values: Collection[str]) -> Problem:
    """Refuse a key that is not a parameter of a block's kind: misspelt, misplaced, or a port."""
    if key in TOP_KEYS:
        hint = f"after [blocks.{name}] it belongs to that block: move it above the first [blocks. ...]"
    elif key in kind.inputs:
        hint = f'{key} is an input: connect it in wires, as in "block.output -> {name}.{key}"'
    elif key in kind.outputs:
        hint = f'{key} is an output: record it in probes, as in "{name}.{key}"'
    else:
        hint = did_you_mean(key, [*kind.parameters, *BLOCK_KEYS], f"the parameters of {kind.__name__}", values)
    path = ("blocks", name, key)
    return Problem(message=f"{kind.__name__} has no such parameter", got=shown(key), hint=hint, path=path)


def note_line(place: Place, path: KeyPath, other: KeyPath) -> None:
    """Note the line of a key that has another name in the graph than in the file."""
    place.lines.setdefault(place.top + path, place.line(other))


def _leaves(table: Mapping[str, object], path: KeyPath) -> Iterator[tuple[KeyPath, object]]:
    """Values of a table and of nested tables: `adc.reference = 5` is a table in a table."""
    for key, value in table.items():
        if isinstance(value, dict) and value:
            yield from _leaves(value, (*path, key))
        else:
            yield (*path, key), value


def _misplaced(name: str, part: Graph, key: str, table: Collection[str]) -> str:
    """Hint for a key of a subgraph that is not an exported parameter; empty if it is one."""
    flat = flatten(part)
    exports, rates = exported(flat), [n for n, signal in flat.exports.items() if is_rate(flat, signal)]
    if key in rates:
        return ""
    if key in exports:
        if not isinstance(exports[key][1], Port):
            return ""
        return f'{key} is a port: connect it in wires, as in "{name}.{key} -> block.input", or the other way round'
    if key in TOP_KEYS and key not in PART_KEYS:
        return f"after [blocks.{name}] it belongs to that block: move it above the first [blocks. ...]"
    if key in part.values or is_value(part, part.exports.get(key, key)):
        return ""
    names = [*settable(part), *PART_KEYS]
    return did_you_mean(key, names, "its values and the parameters that it exports", table) + ONE_INSIDE
