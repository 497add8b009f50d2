"""Small changes of the source, one at a time, each against the tests nearest to it: which of them nobody notices.

    python -m tests.mutants --count 300 --seed 1 --exhaustive

A mutant is one operator, number or word changed in a copy of the project. The tests that pass its line run, quickest
first, as `make coverage` has measured them, or `python -m tests.coverage tests/ROOM` for one room; without that those
nearest to its file: the one of its name, those that import it, or those of its folder. What they all pass has survived.
Of those with a reason in `mutants_that_stay.toml` nothing is expected.

No number meets a tolerance, and both sides of a clip are its bound there: `<` is not changed to `<=` at these, but to
`>=` at the former. Numbers are doubled, and tolerances multiplied by a million.

mutmut calls each function by way of another one, whose syntax tree would be compiled in its place. cosmic-ray runs the
same tests for every file.
"""

import argparse
import ast
import itertools
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import networkx as nx

from tests.coverage import SECONDS, Passing

ROOT = Path(__file__).parents[1]
ROOMS = ("blocks", "graphs/checks", "graphs/files", "graphs/formulas", "graphs/model", "graphs/studies")
ROOMS += tuple(
    f"runner/{room}"
    for room in (
        *("analysis", "comparison", "continuous", "derivatives", "design", "fixed", "plan", "planning", "program"),
        *("reference", "run", "studies", "targets", "verification"),
    )
)
COPIED = ("blocks", "graphs", "runner", "src", "tests", "benchmarks", "docs", "pyproject.toml", "README.md", "Makefile")
STAY = Path(__file__).with_name("mutants_that_stay.toml")
BUDGET = 60.0  # seconds of tests, as they were measured, beside the one of the file's name
HANGS = 400.0  # seconds, after which a mutant counts as noticed: it does not end

_SWAPPED: dict[type[ast.AST], str] = {
    **{ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "=="},
    **{ast.Is: "is not", ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in", ast.And: "or", ast.Or: "and"},
    **{ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.FloorDiv: "*", ast.Mod: "*", ast.Pow: "*"},
    **{ast.LShift: ">>", ast.RShift: "<<", ast.BitAnd: "|", ast.BitOr: "&", ast.BitXor: "&"},
}
_TURNED: dict[type[ast.AST], str] = {ast.Lt: ">=", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<"}
_TOLERANCE = 1e-3  # a number up to there is one
_MUCH = "1e6"  # a tolerance twice as large is as good
_IMPORT = re.compile(r"^ *(?:from ([\w.]+) import (\([^)]*\)|[^\n(]*)|import ([\w.]+))", re.MULTILINE)
_NAMES = {"min": "max", "max": "min", "any": "all", "all": "any"}


class Mutant(NamedTuple):
    """A change of one place of a file."""

    file: str
    line: int
    first: int  # offset of the first byte that changes
    last: int
    new: str

    def text(self, source: bytes) -> bytes:
        """The file with the change."""
        return source[: self.first] + self.new.encode() + source[self.last :]

    def told(self, source: bytes) -> tuple[str, str]:
        """The line before and after."""
        before, after = (text.decode().splitlines()[self.line - 1].strip() for text in (source, self.text(source)))
        return before, after


def mutants(file: str) -> Iterator[Mutant]:
    """Every change that is made of a file."""
    return (mutant for mutant in _changes(file) if _parses(mutant))


def _changes(file: str) -> Iterator[Mutant]:
    """Every change, also those that are no longer Python."""
    source = (ROOT / file).read_bytes()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def at(line: int | None, column: int | None) -> int:
        return starts[(line or 1) - 1] + (column or 0)

    tree = ast.parse(source)
    tolerances, clips = _tolerances(tree), _clips(tree)

    def between(left: ast.expr, right: ast.expr, new: str) -> Mutant | None:
        """The operator between two operands, which stand in parentheses or not."""
        first, last = at(left.end_lineno, left.end_col_offset), at(right.lineno, right.col_offset)
        gap = source[first:last].decode()
        old = gap.strip(" ()\n")
        if not old or "#" in gap or any(letter in old for letter in "()\n"):
            return None
        begin = first + len(gap[: gap.index(old)].encode())
        return Mutant(file, left.end_lineno or 1, begin, begin + len(old), new)

    for node in _code(tree):
        match node:
            case ast.Compare(left, [operator], [right]) if type(operator) in _TURNED:
                at_tolerance = any(_of_tolerance(side, tolerances) for side in (left, right))
                turned = (_TURNED if at_tolerance else _SWAPPED)[type(operator)]
                found = None if node in clips else between(left, right, turned)
            case ast.Compare(left, [operator], [right]):
                found = between(left, right, _SWAPPED[type(operator)])
            case ast.BinOp(left, operator, right) if type(operator) in _SWAPPED:
                found = between(left, right, _SWAPPED[type(operator)])
            case ast.BoolOp(operator, [left, right, *_]):
                found = between(left, right, _SWAPPED[type(operator)])
            case ast.Constant(bool() | int() | float() as value):
                found = Mutant(file, node.lineno, at(node.lineno, node.col_offset), _end(node, at), _other(value))
            case ast.UnaryOp(ast.Not() | ast.USub(), inside):
                place = at(node.lineno, node.col_offset)
                found = Mutant(file, node.lineno, place, at(inside.lineno, inside.col_offset), "")
            case ast.Break() | ast.Continue():
                new = "continue" if isinstance(node, ast.Break) else "break"
                found = Mutant(file, node.lineno, at(node.lineno, node.col_offset), _end(node, at), new)
            case ast.Call(ast.Name(name) as called) if name in _NAMES:
                found = Mutant(file, node.lineno, at(called.lineno, called.col_offset), _end(called, at), _NAMES[name])
            case _:
                found = None
        if found is not None:
            yield found


def _other(value: float) -> str:
    if isinstance(value, bool):
        return f"({not value})"
    if value in (0, 1):
        return f"({value + 1})"
    return f"({value}*{_MUCH if isinstance(value, float) and value <= _TOLERANCE else 2})"


def _tolerances(tree: ast.Module) -> set[str]:
    """Return the names of a file's constants that are tolerances."""
    rows = [node for node in tree.body if isinstance(node, ast.Assign) and _of_tolerance(node.value, set())]
    return {target.id for row in rows for target in row.targets if isinstance(target, ast.Name)}


def _of_tolerance(node: ast.expr, names: set[str]) -> bool:
    """Return whether an expression is a tolerance, or a multiple of one."""
    match node:
        case ast.Constant(float() as value):
            return 0.0 < value <= _TOLERANCE
        case ast.Name(name):
            return name in names
        case ast.BinOp(left, ast.Mult() | ast.Pow() as operator, right):
            power = isinstance(operator, ast.Pow) and isinstance(left, ast.Constant) and isinstance(right, ast.UnaryOp)
            return power or _of_tolerance(left, names) or _of_tolerance(right, names)
        case _:
            return False


def _clips(tree: ast.Module) -> set[ast.expr]:
    """Return the comparisons of `a if a < b else b` where b is a number other than 0, which has no sign to lose."""
    found = set[ast.expr]()
    for node in ast.walk(tree):
        match node:
            case ast.IfExp(ast.Compare(left, [_], [right]) as test, body, last) if _is_number(left) or _is_number(
                right
            ):
                while isinstance(last, ast.IfExp):  # the other bound of a clip
                    last = last.orelse
                if {ast.dump(left), ast.dump(right)} == {ast.dump(body), ast.dump(last)}:
                    found.add(test)
    return found


def _is_number(node: ast.expr) -> bool:
    inside = node.operand if isinstance(node, ast.UnaryOp) else node
    return isinstance(inside, ast.Constant) and isinstance(inside.value, int | float) and inside.value != 0


def _end(node: ast.expr | ast.stmt, at: object) -> int:
    return at(node.end_lineno, node.end_col_offset)  # type: ignore[operator, no-any-return]


def _parses(mutant: Mutant) -> bool:
    try:
        ast.parse(mutant.text((ROOT / mutant.file).read_bytes()))
    except SyntaxError:
        return False
    return True


def _code(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield what runs: no annotations, messages or assertions, and not the `strict` of what is of one length."""
    if isinstance(tree, ast.Assert | ast.Raise | ast.JoinedStr) or (
        isinstance(tree, ast.keyword) and tree.arg == "strict"
    ):
        return
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "type_params"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield child
                yield from _code(child)


# -- the tests nearest to a file -------------------------------------------------------------------------------------


_DECLARED = ("tests/blocks/test_declared_numbers.py",)  # what a class of a block says is read at import
_FROZEN = ("tests/test_frozen.py",)  # what is said of dataclasses


class Nearest:
    """Which files of tests stand nearest to a line of the source: that pass it, or by name and by imports."""

    def __init__(self, measured: bool = True) -> None:
        self._passing = Passing() if measured and SECONDS.exists() else None
        self._imports = nx.DiGraph()
        for room in ("blocks", "graphs", "runner", "tests"):
            for path in (ROOT / room).rglob("*.py"):
                self._imports.add_edges_from((name, _module(path)) for name in _imported(path))

    def at(self, mutant: Mutant) -> list[str]:
        """Files of tests that pass the line, the one of its name first; those nearest to the file if none does."""
        near, passing = self.of(mutant.file), self._passing.of(mutant.file, mutant.line) if self._passing else {}
        line = (ROOT / mutant.file).read_text(encoding="utf-8").splitlines()[mutant.line - 1]
        read = (*(_DECLARED if mutant.file.startswith("blocks/") else ()), *(_FROZEN if "@dataclass" in line else ()))
        if not passing:
            return [*near, *read]
        named = [test for test in near[:1] if Path(test).stem == f"test_{Path(mutant.file).stem}"]
        tests, seconds = list[str](), 0.0
        for test, more in passing.items():
            seconds += more
            if test not in named and (not tests or seconds <= BUDGET):
                tests.append(test)
        return [*named, *read, *tests]

    def of(self, file: str) -> list[str]:
        """Files of tests, the one of its name first; those that import it by way of others only if no one else does."""
        path = ROOT / file
        named = ROOT / "tests" / Path(file).parent / f"test_{path.name}"
        found = [named] if named.exists() else []
        module = _module(path)
        if module in self._imports:
            for ring in nx.bfs_layers(self._imports, [module]):
                tests = sorted(ROOT / f"{name.replace('.', '/')}.py" for name in ring if _tests(name))
                found += [test for test in tests if test not in found and test.exists()]
                if found:
                    break
        folder = named.parent
        while not found and folder != ROOT:
            found, folder = sorted(folder.rglob("test_*.py")), folder.parent
        return [str(test.relative_to(ROOT)) for test in found]


def _tests(module: str) -> bool:
    return module.startswith("tests.") and module.rpartition(".")[2].startswith("test_")


def _module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts if parts[0] == "tests" else ("proofmass", *parts)).removesuffix(".__init__")


def _imported(path: Path) -> Iterator[str]:
    """Yield the names that a file imports, by their form: syntax trees of a thousand files take ten seconds."""
    for module, names, alone in _IMPORT.findall(path.read_text(encoding="utf-8")):
        yield module or alone
        yield from (f"{module}.{name}" for name in re.findall(r"(\w+)(?: as \w+)?", names))


# -- one mutant after the other -------------------------------------------------------------------------------------


class Outcome(NamedTuple):
    """What became of a mutant."""

    mutant: Mutant
    before: str
    after: str
    noticed: str  # the test that failed; "" if none did
    tests: int  # files that ran


def examined(mutant: Mutant, copy: Path, tests: Sequence[str], exhaustive: bool = False) -> Outcome:
    """Run the nearest tests in a copy of the project that has the change, and undo it.

    What none of them notices, the `exhaustive` ones of the nearest file may.
    """
    changed, source = copy / mutant.file, (ROOT / mutant.file).read_bytes()
    before, after = mutant.told(source)
    _write(changed, mutant.text(source))
    try:
        noticed = _failed(copy, tests) if tests else ""
        if tests and exhaustive and not noticed:
            noticed = _failed(copy, [*tests[:1], "--exhaustive"], ends=False)
    finally:
        _write(changed, source)
    return Outcome(mutant, before, after, noticed, len(tests))


_moments = itertools.count(1_000_000_000)


def _write(file: Path, text: bytes) -> None:
    """Write a file at a moment of its own: Python compiles anew what has another time, in whole seconds."""
    file.write_bytes(text)
    moment = next(_moments)
    os.utime(file, (moment, moment))


def _failed(copy: Path, tests: Sequence[str], ends: bool = True) -> str:
    """Return the first test of some files that fails, or ""; those that usually end fail if they do not."""
    environment = {**os.environ, "PYTHONPATH": f"{copy / 'src'}{os.pathsep}{copy}"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", *tests]
    try:
        done = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, text=True, timeout=HANGS, check=False
        )
    except subprocess.TimeoutExpired:
        return f"{tests[0]}: does not end" if ends else ""
    if done.returncode in (0, 5):  # 5: no test is there
        return ""
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].partition(" ")[2].partition(" - ")[0] if failed else tests[0]


def chosen(count: int, seed: int, rooms: Sequence[str]) -> list[Mutant]:
    """Return so many mutants at random, every place as likely."""
    files = sorted(
        str(path.relative_to(ROOT))
        for room in rooms
        for path in ([ROOT / room] if room.endswith(".py") else (ROOT / room).rglob("*.py"))
    )
    every = [mutant for file in files for mutant in _changes(file)]
    dealt = random.Random(seed).sample(every, len(every))
    return list(itertools.islice(filter(_parses, dealt), count))  # to parse a file takes longer than all its changes


def reasons() -> dict[tuple[str, str, str], str]:
    """Return why mutants may survive, by file, line before and line after."""
    rows = tomllib.loads(STAY.read_text())["mutant"] if STAY.exists() else []
    return {(row["file"], row["before"], row["after"]): row["reason"] for row in rows}


def run(count: int, seed: int, rooms: Sequence[str] = ROOMS, exhaustive: bool = False) -> Iterator[Outcome]:
    """Examine mutants, one after the other."""
    nearest = Nearest()
    with project_copied() as copy:
        for mutant in chosen(count, seed, rooms):
            yield examined(mutant, copy, nearest.at(mutant), exhaustive)


@contextmanager
def project_copied() -> Iterator[Path]:
    """A copy of the project, in which files may change."""
    with tempfile.TemporaryDirectory(prefix="proofmass-mutants-") as folder:
        for name in COPIED:
            source, copy = ROOT / name, Path(folder) / name
            if source.is_dir():
                shutil.copytree(source, copy, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, copy)
        yield Path(folder)


def main() -> int:
    """Print every survivor, and how many there are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("rooms", nargs="*", default=list(ROOMS), help="folders or files")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--exhaustive", action="store_true", help="exhaustive tests of the nearest file too")
    arguments = parser.parse_args()
    known, survived, examined_ones = reasons(), 0, 0
    for outcome in run(arguments.count, arguments.seed, arguments.rooms, arguments.exhaustive):
        examined_ones += 1
        if outcome.noticed:
            continue
        reason = known.get((outcome.mutant.file, outcome.before, outcome.after), "")
        survived += not reason
        print(f"{outcome.mutant.file}:{outcome.mutant.line}: {outcome.tests} files of tests pass", flush=True)
        print(f"    {outcome.before}\n    {outcome.after}", flush=True)
        if reason:
            print(f"    stays: {reason}", flush=True)
    print(f"{examined_ones} mutants, {survived} survive without a reason", flush=True)
    return int(survived > examined_ones // 20)


if __name__ == "__main__":
    sys.exit(main())
