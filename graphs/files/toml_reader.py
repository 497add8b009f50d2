"""A graph from a TOML file, with the line of every problem. Nothing in the file is evaluated, imported or fetched."""

import math
import tomllib
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.catalog import Own
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, collecting, did_you_mean, nearest, shown
from proofmass.graphs.checks.check import check_apart_from
from proofmass.graphs.files.block_tables import BlockTables, note_line
from proofmass.graphs.files.library import LIBRARY, file_of, library_files
from proofmass.graphs.files.locate_keys import KeyPath, LimitError, locate_keys, repeated_key
from proofmass.graphs.files.part_files import PartFiles
from proofmass.graphs.files.table_formulas import TableFormulas
from proofmass.graphs.model.build import Graph, above_of, read_probe, read_wire
from proofmass.graphs.model.graph import AnyGraph, Place
from proofmass.graphs.model.graph import Graph as Value
from proofmass.graphs.model.hints import TWICE, known_as, syntax_hint
from proofmass.graphs.model.keys import STUDY_KEYS, TUNE_KEYS
from proofmass.graphs.model.limits import FILE_BYTES, PROBLEMS
from proofmass.graphs.model.top_keys import TOP_KEYS
from proofmass.graphs.model.values import read_values

_COMPARED = 1000  # at most so many files of a folder are compared with a misspelt name
_OTHERS = ("name", "exports", "rate", "measures", "loops", "values")  # keys needed to check wires and signals
_NAMES = ("values", "measures", "loops", "requirements")  # tables of names that a file chooses
_KEYS_ELSEWHERE = {  # tables in which a key of the graph is in the wrong place, but for those that are their own too
    **dict.fromkeys((*_NAMES, "integration"), ()),
    "study": STUDY_KEYS,
    "tune": TUNE_KEYS,
}
_ANY_RATE = "1 kHz"  # stands in for a rate that cannot be read, so that wires can be checked


GraphSource = Value | str | Path  # a graph, its file, or "library:NAME"


def graph_from(source: AnyGraph | str | Path) -> AnyGraph | Graph:
    """Return a graph itself, or the graph of its file or of "library:NAME"; raises `ModelError`."""
    if isinstance(source, str | Path):
        return read_graph(source)
    if not isinstance(source, Value):
        hint = 'name its file, or write Graph(name="...", rate="1 kHz", blocks={...}, wires=[...], probes=[...])'
        raise Problem(message="this is not a graph", got=shown(source), hint=hint).error
    return source


def read_graph(path: str | Path, own: Own | None = None) -> Graph:
    """The graph of a file; `own` are the caller's own blocks by name.

    A block that is a graph is read from a file in the same folder or below it, or from the packaged
    library.

    Raises `ModelError` with every problem that can be seen, each with file, line and key.

    `path` is a file, or "library:NAME" for a graph that comes along.

    >>> from proofmass import read_graph
    >>> graph = read_graph("library:closed_loop_accelerometer")
    >>> graph.name, str(graph.rate), list(graph.loops)
    ('closed-loop accelerometer', '50000', ['main'])
    """
    path = file_of(path)
    return graph_of_file(*read_table(path), own, path)


def read_graph_text(text: str, file: str = "<text>", own: Own | None = None, folder: str = ".") -> Graph:
    """The graph of a TOML text; file names in it start from `folder`."""
    return graph_of_file(*parsed(text, file, folder), own)


def graph_of_file(data: dict[str, Any], place: Place, own: Own | None, path: Path | None = None) -> Graph:
    """The graph of a parsed file; raises `ModelError`."""

    def part(path: Path, files: PartFiles, depth: int) -> Graph:
        return graph_of_table(*read_table(path), own, files, depth)

    return graph_of_table(data, place, own, PartFiles(part, path), 0)


def read_table(path: Path) -> tuple[dict[str, Any], Place]:
    """A parsed TOML file and the lines of its keys; raises `ModelError`."""
    try:
        with path.open("rb") as file:
            data = file.read(FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise Problem(message=f"cannot be read: {reason}", file=str(path), hint=_others(path)).error from None
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        if len(data) > FILE_BYTES:
            raise _too_large(str(path)) from None
        line = data.count(b"\n", 0, error.start) + 1
        raise _refused(str(path), line, "not UTF-8 text", "save the file as UTF-8") from None
    return parsed(text, str(path), str(path.parent))


def graph_of_table(data: dict[str, Any], place: Place, own: Own | None, files: PartFiles, depth: int) -> Graph:
    """The graph of a parsed file, or of a table of a subgraph inside it, `depth` levels down."""
    if depth == 0 and "blocks" not in data and isinstance(data.get("graph"), str):
        hint = f"proofmass montecarlo runs it; its graph is {data['graph']}"
        raise Problem(message="this is a study, not a graph", file=place.file, hint=hint).error
    data, problems = _with_keys_at_top(data, place)
    problems += [
        Refusal("unknown key", _meant(key, data)).problem(key, key, path=(key,)) for key in data if key not in TOP_KEYS
    ]
    formulas = TableFormulas(read_values(data.get("values", {}), {})[0], data.get("values"))
    reader = BlockTables(
        own, place, files, depth, lambda table, inner: graph_of_table(table, inner, own, files, depth + 1), formulas
    )
    reader.read(data.get("blocks", {}))
    reader.doubtful |= {key for key, entry in data.items() if key not in TOP_KEYS and _is_block(entry)}
    reader.doubtful |= formulas.waiting
    problems += formulas.problems
    settings = {
        "name": "",
        **{key: value for key, value in data.items() if key in TOP_KEYS and key not in ("blocks", "study", "tune")},
    }
    for key in ("wires", "probes"):
        if not isinstance(settings.get(key, []), list):
            got, hint = shown(settings.pop(key)), f"{key} is a list of texts in square brackets"
            problems.append(Problem(message="must be a list", got=got, hint=hint, path=(key,)))
    _note_wires(place, settings.get("wires", []))
    if isinstance(settings.get("formulas", {}), dict):
        all_formulas = {**formulas.formulas, **settings.get("formulas", {})}
        doubtful = reader.doubtful
        settings["formulas"] = {of: f for of, f in all_formulas.items() if doubtful.isdisjoint(above_of(of))}
    graph = None
    with collecting(problems):
        graph = Graph(blocks=reader.blocks, rates=reader.rates, offsets=reader.offsets, place=place, **settings)
    if (problems or reader.problems or graph is None) and reader.named and depth == 0:
        problems += _wiring_beside(problems, reader, place, settings)
    problems += reader.problems
    if problems or graph is None:
        raise ModelError(_in_order(problems, place))
    return graph


def _with_keys_at_top(data: dict[str, Any], place: Place) -> tuple[dict[str, Any], list[Problem]]:
    """Return the graph with its own keys that stand in other tables at its top, and problems."""
    found: dict[KeyPath, object] = {}
    whole, problems = dict(data), []
    for key, own in _KEYS_ELSEWHERE.items():
        if isinstance(data.get(key), dict):
            whole[key] = _without_keys(data[key], (key,), own, found)
    for (*head, key), entry in found.items():
        path, table = (*head, key), ".".join(head)
        hint = f"after [{table}] it belongs to that table: move it above the first table"
        problems.append(Problem(message="stands in the wrong table", hint=hint, path=path))
        if key not in whole:
            whole[key] = entry
            note_line(place, (key,), path)
            for index in range(len(entry) if isinstance(entry, list) else 0):
                note_line(place, (key, str(index)), (*path, str(index)))
    return whole, problems


def _without_keys(
    table: dict[str, Any], path: KeyPath, own: Collection[str], found: dict[KeyPath, object]
) -> dict[str, Any]:
    """Return a table without the keys of the graph in it. A name that a file chooses counts only with a list."""
    kept, names = dict[str, Any](), path[0] in _NAMES
    for key, entry in table.items():
        if names and isinstance(entry, dict):
            kept[key] = _without_keys(entry, (*path, key), own, found)
        elif key in TOP_KEYS and key not in own and (isinstance(entry, list) or not names or len(path) > 1):
            found[*path, key] = entry
        else:
            kept[key] = entry
    return kept


def _meant(key: str, data: Mapping[str, object]) -> str:
    """Return what an unknown key at the top of a file was meant to be."""
    if _is_block(data[key]) and not nearest(key, TOP_KEYS):
        return f"a block stands under blocks: write [blocks.{key}]"
    of_study = key if key in STUDY_KEYS else known_as(key, STUDY_KEYS)
    if of_study:
        where = f"[study.{of_study}]" if isinstance(data[key], dict) else f"{of_study} = ... below [study]"
        return f"studies have {of_study}: write {where}, or in a study file of its own"
    return did_you_mean(key, TOP_KEYS, "the keys", data)


def _is_block(entry: object) -> bool:
    return isinstance(entry, dict) and "kind" in entry


def _wiring_beside(
    problems: list[Problem], reader: BlockTables, place: Place, settings: dict[str, Any]
) -> list[Problem]:
    """Return the faults of the wiring, apart from what could not be read."""
    wrong = {problem.path[0] for problem in problems if problem.path}
    rates = {name: rate for name, rate in reader.rates.items() if not wrong & {"blocks", "rate"}}
    readable: dict[str, Any] = {}
    for key, read in (("wires", read_wire), ("probes", read_probe)):
        readable[key] = list(_readable(settings.get(key, []), read))
    whole = len(readable["wires"]) == len(settings.get("wires", []))
    readable |= {key: settings[key] for key in _OTHERS if key in settings and key not in wrong}
    try:
        graph = Graph(blocks=reader.blocks, rates=rates, place=place, **{"name": "", "rate": _ANY_RATE, **readable})
    except ModelError:
        return []  # problems of the blocks themselves have been reported
    found = check_apart_from(graph, reader.doubtful)
    return [problem for problem in found if whole or problem.path[0] != "blocks"]


def _readable(entries: list[object], read: Callable[[object], object]) -> Iterator[object]:
    """The entries of a list that can be read."""
    for entry in entries:
        with suppress(Refusal):
            read(entry)
            yield entry


def parsed(text: str, file: str, folder: str) -> tuple[dict[str, Any], Place]:
    """A TOML text and the lines of its keys; raises `ModelError`."""
    if len(text) > FILE_BYTES or len(text.encode("utf-8", "surrogatepass")) > FILE_BYTES:
        raise _too_large(file)
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise _refused(file, line, "holds a NUL character", "save it as plain text")
    text = text.removeprefix("\ufeff").replace("\r\n", "\n")
    try:
        lines = locate_keys(text)  # first: the parser takes minutes for what is refused here
        return tomllib.loads(text, parse_float=held_float), Place(file, lines, folder)
    except LimitError as error:
        raise _refused(file, error.line, str(error)) from None
    except (ValueError, RecursionError) as error:
        message, _, place = str(error).partition(" (at ")
        texts = text.rstrip("\n").split("\n")
        word, _, rest = place.partition(" ")
        line = int(rest.partition(",")[0]) if word == "line" else len(texts)
        if Path(file).suffix not in ("", ".toml") and not file.startswith("<"):
            raise _refused(file, line, "this is not a graph file: it is not TOML", _graphs_beside(Path(file))) from None
        hint = syntax_hint(message, texts[line - 1] if line <= len(texts) else "")
        if message.startswith(TWICE) and (twice := repeated_key(text, line)):
            message = f"{'.'.join(twice[0])} is given twice, in lines {twice[1]} and {line}"
        raise _refused(file, line, f"not TOML: {message}", hint) from None


def held_float(text: str) -> float | str:
    """Return a float of a file; one that is too large or too small for a float stays text, which no reader takes."""
    number, digits = float(text), text.lower().partition("e")[0].strip("+-0_.")
    return text if digits[:1].isdigit() and number in (0.0, math.inf, -math.inf) else number


def _graphs_beside(path: Path) -> str:
    """Return a hint at the graph that stands beside a file of another kind."""
    files = sorted(file.name for file in islice(path.parent.glob("*.toml"), _COMPARED))
    near = nearest(path.stem, (name.removesuffix(".toml") for name in files))
    name = f"{near}.toml" if near else files[0] if files else ""
    return f"did you mean {path.with_name(name)}?" if name else "proofmass new sensor.toml writes a graph to start from"


def _others(path: Path) -> str:
    """Return a hint at a file named nearly as the missing one, in its folder or the library."""
    if path.exists():
        return ""
    if path.name in library_files():
        return f"one of this name comes along: {LIBRARY}{path.stem}"
    if not path.parent.is_dir():
        return f"there is no folder {path.parent}"
    near = nearest(path.stem, (file.stem for file in islice(path.parent.glob("*.toml"), _COMPARED)))
    if near:
        return f"did you mean {path.with_name(near + '.toml')}?"
    own = nearest(path.stem.removeprefix(LIBRARY), (Path(name).stem for name in library_files()))
    return f"did you mean {LIBRARY}{own}?" if own else ""


def _refused(file: str, line: int, message: str, hint: str = "") -> ModelError:
    return Problem(message=message, file=file, line=line, hint=hint).error


def _too_large(file: str) -> ModelError:
    return _refused(file, 0, f"larger than {FILE_BYTES >> 10} KiB", "put recorded data into a file of its own")


def _in_order(problems: list[Problem], place: Place) -> list[Problem]:
    """Each problem once, with its place, in the order of the file."""
    ordered = list(dict.fromkeys(place.in_order(problems)))
    more = len(ordered) - PROBLEMS
    if more <= 0:
        return ordered
    return [*ordered[:PROBLEMS], Problem(message="and more problems", file=place.file, line=ordered[PROBLEMS].line)]


def _note_wires(place: Place, wires: list[Any]) -> None:
    """Note the lines of wires by their text, since a graph sorts them."""
    for index, text in enumerate(wires):
        if isinstance(text, str) and text.count("->") == 1:
            normal = " -> ".join(end.strip() for end in text.split("->"))
            note_line(place, ("wires", normal), ("wires", str(index)))
