"""Small changes of the source, one at a time, each against the tests nearest to it: which of them nobody notices.

    python -m tests.mutants --count 300 --seed 1 --exhaustive

A mutant is one operator, number or word changed in a copy of the project. The tests that pass its line run, as
`python -m tests.coverage --by-test` has measured them: those of the file of its name, then the quickest of every other
file, the next one of each, and so on. Where nothing is measured these are the files nearest to its own: the one of its
name, those that import it, then those of its folder. What passes them within `BUDGET` has survived. Of those with a
reason in `mutants_that_stay.toml` nothing is expected.

They run in a process that forks from one with the large libraries and nothing of the project. It compiles the changed
file and all machine code anew. If it crashes, or a test does not end, that counts as noticed.

Numbers that say how a picture looks are not changed, as the width of a line, but those that say where it lies are.
No number meets a tolerance, and both sides of a clip are its bound there: `<` is not changed to `<=` at these, but to
`>=` at the former. Numbers are doubled, and tolerances multiplied by a million.

mutmut calls each function by way of another one, whose syntax tree would be compiled in its place. cosmic-ray runs the
same tests for every file.
"""

import argparse
import ast
import itertools
import multiprocessing
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.nearest import BUDGET, Nearest

ROOT = Path(__file__).parents[1]
_GRAPHS = ("checks", "files", "formulas", "model", "studies")
_RUNNER = "analysis comparison continuous derivatives design fixed plan planning program reference run studies targets"
ROOMS = ["blocks", *(f"graphs/{room}" for room in _GRAPHS)]
ROOMS += [f"runner/{room}" for room in (*_RUNNER.split(), "verification")]
COPIED = ("blocks", "graphs", "runner", "src", "tests", "benchmarks", "docs", "pyproject.toml", "README.md", "Makefile")
STAY = Path(__file__).with_name("mutants_that_stay.toml")
HANGS = 60  # seconds of one test, after which it counts as failed: it does not end; ten times if it is exhaustive
LIBRARIES = (
    "numpy scipy.linalg scipy.optimize scipy.signal scipy.stats scipy.integrate networkx llvmlite.binding mpmath"
)
LIBRARIES += " flint control matplotlib.figure pandas hypothesis pytest"

_SWAPPED: dict[type[ast.AST], str] = {
    **{ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "=="},
    **{ast.Is: "is not", ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in", ast.And: "or", ast.Or: "and"},
    **{ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.FloorDiv: "*", ast.Mod: "*", ast.Pow: "*"},
    **{ast.LShift: ">>", ast.RShift: "<<", ast.BitAnd: "|", ast.BitOr: "&", ast.BitXor: "&"},
}
_TURNED: dict[type[ast.AST], str] = {ast.Lt: ">=", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<"}
_TOLERANCE = 1e-3  # a number up to there is one
_MUCH = "1e6"  # a tolerance twice as large is as good
_SKIPPED = frozenset({"strict"})
_LOOKS = frozenset(  # how a picture looks, and not what it says
    [
        "linewidth",
        "size",
        "fontsize",
        "markersize",
        "markeredgewidth",
        "alpha",
        "height",
        "ncols",
        "bbox_to_anchor",
        "pad",
    ]
)
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

    def instead(node: ast.expr | ast.stmt, new: str) -> Mutant:
        place, end = at(node.lineno, node.col_offset), at(node.end_lineno, node.end_col_offset)
        return Mutant(file, node.lineno, place, end, new)

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

    for node in _code(tree, _SKIPPED | _LOOKS if Path(file).stem == "plot" else _SKIPPED):
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
                found = instead(node, _other(value))
            case ast.UnaryOp(ast.Not() | ast.USub(), inside):
                place = at(node.lineno, node.col_offset)
                found = Mutant(file, node.lineno, place, at(inside.lineno, inside.col_offset), "")
            case ast.Break() | ast.Continue():
                found = instead(node, "continue" if isinstance(node, ast.Break) else "break")
            case ast.Call(ast.Name(name) as called) if name in _NAMES:
                found = instead(called, _NAMES[name])
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
        case ast.UnaryOp(ast.USub(), inside):
            return _of_tolerance(inside, names)
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
            case ast.IfExp(ast.Compare(left, [_], [right]) as test, body, last) if any(map(_is_number, (left, right))):
                while isinstance(last, ast.IfExp):  # the other bound of a clip
                    last = last.orelse
                if {ast.dump(left), ast.dump(right)} == {ast.dump(body), ast.dump(last)}:
                    found.add(test)
    return found


def _is_number(node: ast.expr) -> bool:
    inside = node.operand if isinstance(node, ast.UnaryOp) else node
    return isinstance(inside, ast.Constant) and isinstance(inside.value, int | float) and inside.value != 0


def _parses(mutant: Mutant) -> bool:
    with suppress(SyntaxError):
        return bool(ast.parse(mutant.text((ROOT / mutant.file).read_bytes())))
    return False


def _code(tree: ast.AST, skipped: AbstractSet[str]) -> Iterator[ast.AST]:
    """Yield what runs: no annotations, messages or assertions, and not the `strict` of what is of one length.

    Keywords of the names that are `skipped` are left out, and the size of a sheet.
    """
    if isinstance(tree, ast.Assert | ast.Raise | ast.JoinedStr) or (
        isinstance(tree, ast.keyword) and tree.arg in skipped
    ):
        return
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and tree.func.id == "sheet":
        return
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "type_params"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield child
                yield from _code(child, skipped)


# -- one mutant after the other -------------------------------------------------------------------------------------


def examined(mutant: Mutant, copy: Path, tests: Sequence[str], exhaustive: bool = False) -> str:
    """Return the first of the nearest tests, or files of them, that fails in a copy of the project with the change.

    What none of them notices, the `exhaustive` ones of the nearest file may. If none does, it is "".
    """
    changed, source = copy / mutant.file, (ROOT / mutant.file).read_bytes()
    _write(changed, mutant.text(source))
    slow = [*(test.partition("::")[0] for test in tests[:1]), "--exhaustive"]
    try:
        return _failed(copy, tests) or (_failed(copy, slow, 10) if exhaustive else "")
    finally:
        _write(changed, source)


_moments = itertools.count(1_000_000_000)


def _write(file: Path, text: bytes) -> None:
    """Write a file at a moment of its own: Python compiles anew what has another time, in whole seconds."""
    file.write_bytes(text)
    moment = next(_moments)
    os.utime(file, (moment, moment))


_processes = multiprocessing.get_context("forkserver")
_processes.set_forkserver_preload([*LIBRARIES.split()])


def _failed(copy: Path, words: Sequence[str], longer: int = 1) -> str:
    """Return the first test of some files that fails, or the first file if tests crash or do not end, or ""."""
    said = copy / "noticed.txt"
    said.write_text(words[0])
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # read when the libraries are imported
    process = _processes.Process(target=_run_tests, args=(copy, words, said, longer))
    process.start()
    process.join()
    with suppress(ProcessLookupError):
        os.killpg(process.pid or 0, signal.SIGKILL)  # what tests have started and left
    return said.read_text()


def _run_tests(copy: Path, words: Sequence[str], said: Path, longer: int) -> None:
    """Run tests of the copy, and write which one fails first; to be called in a process of its own."""
    os.setsid()
    sys.dont_write_bytecode = False  # most files do not change from one mutant to the next
    os.chdir(copy)
    for output in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), output)
    sys.path[:] = [str(copy / "src"), str(copy), *(path for path in sys.path if Path(path) not in (ROOT, ROOT / "src"))]
    tempfile.tempdir = str(copy.with_name("temporary"))  # not in the project, as tests expect
    Path(tempfile.tempdir).mkdir(exist_ok=True)
    os.environ |= {"PYTHONPATH": os.pathsep.join(sys.path[:2]), "TMPDIR": tempfile.tempdir}
    for name in [name for name in sys.modules if name.partition(".")[0] in ("tests", "proofmass")]:
        del sys.modules[name]

    def seen(report: pytest.CollectReport | pytest.TestReport) -> None:
        signal.alarm(longer * HANGS)  # which kills this process, also in machine code
        if report.failed or sum(os.times()[:4]) > longer * BUDGET:
            said.write_text(report.nodeid if report.failed else "")
            os._exit(0)

    def choose(items: list[pytest.Item]) -> None:
        items[:] = [item for item in items if {item.nodeid, item.nodeid.partition("::")[0]} & wanted]

    wanted = {*words}
    signal.alarm(longer * HANGS)
    hooks = {"pytest_collectreport": seen, "pytest_runtest_logreport": seen, "pytest_collection_modifyitems": choose}
    plugin = type("Seen", (), hooks)
    files = dict.fromkeys(word.partition("::")[0] for word in words)
    code = pytest.main(["-q", "--assert=plain", "-p", "no:cacheprovider", "-p", "no:xdist", *files], plugins=[plugin])
    said.write_text("" if code in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED) else words[0])


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


@contextmanager
def project_copied() -> Iterator[Path]:
    """A copy of the project, in which files may change."""
    with tempfile.TemporaryDirectory(prefix="proofmass-mutants-") as folder:
        project = Path(folder) / "project"
        project.mkdir()
        for name in COPIED:
            source, copy = ROOT / name, project / name
            if source.is_dir():
                shutil.copytree(source, copy, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, copy)
        yield project


def main() -> int:
    """Print every survivor, and how many there are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("rooms", nargs="*", default=ROOMS, help="folders or files")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--exhaustive", action="store_true", help="exhaustive tests of the nearest file too")
    arguments = parser.parse_args()
    nearest, known, noticed, survived, begun = Nearest(), reasons(), set[str](), 0, time.monotonic()
    changes = chosen(arguments.count, arguments.seed, arguments.rooms)
    with project_copied() as copy:
        for mutant in changes:
            tests = nearest.at(mutant.file, mutant.line)
            if test := examined(mutant, copy, tests, arguments.exhaustive):
                noticed.add(test)
                continue
            before, after = mutant.told((ROOT / mutant.file).read_bytes())
            reason = known.get((mutant.file, before, after), "")
            survived += not reason
            told = [f"{mutant.file}:{mutant.line}: {len(tests)} tests pass", before, after]
            print(*told, *([f"stays: {reason}"] if reason else []), sep="\n    ", flush=True)
        seconds = (time.monotonic() - begun) / len(changes)
        unsound = _failed(copy, sorted(noticed), 100) if noticed else ""
    print(f"{len(changes)} mutants, {survived} survive without a reason, {seconds:.1f} s each")
    if unsound:
        print(f"{unsound} fails without any change: what it has noticed counts for nothing")
    return int(survived > len(changes) // 20 or bool(unsound))


if __name__ == "__main__":
    sys.exit(main())
