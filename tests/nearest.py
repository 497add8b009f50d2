"""The tests nearest to a line of the source: those that pass it, or those of files by name and by imports."""

import itertools
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import networkx as nx

from tests.coverage import SECONDS, Passing

ROOT = Path(__file__).parents[1]
BUDGET = 20.0  # seconds of processor time, after which no other test of a mutant begins
MOST = 24  # files of tests
_IMPORT = re.compile(r"^ *(?:from ([\w.]+) import (\([^)]*\)|[^\n(]*)|import ([\w.]+))", re.MULTILINE)
_DECLARED = ("tests/blocks/test_declared_numbers.py",)  # what a class of a block says is read at import
_FROZEN = ("tests/test_frozen.py",)  # what is said of dataclasses


class Nearest:
    """Which tests stand nearest to a line of the source: those that pass it, or files by name and by imports."""

    def __init__(self, measured: bool = True) -> None:
        self._passing = Passing() if measured and SECONDS.exists() else None
        self._imports = nx.DiGraph()
        for room in ("blocks", "graphs", "runner", "tests"):
            for path in (ROOT / room).rglob("*.py"):
                self._imports.add_edges_from((name, _module(path)) for name in _imported(path))

    def at(self, file: str, line: int) -> list[str]:
        """Tests that pass the line, those of the file of its name first; files nearest to its own if none does."""
        tests = self.of(file)
        if self._passing and (passing := self._passing.of(file, line)):
            tests = dealt(passing, Path(file).stem, BUDGET, MOST)
        text = (ROOT / file).read_text(encoding="utf-8").splitlines()[line - 1]
        read = (*(_DECLARED if file.startswith("blocks/") else ()), *(_FROZEN if "@dataclass" in text else ()))
        return list(dict.fromkeys([*tests[:1], *read, *tests[1:]]))

    def of(self, file: str) -> list[str]:
        """Files of tests: the one of its name, those that import it, those of its folder, those that import least."""
        named = Path("tests", file).with_name(f"test_{Path(file).name}")
        module = _module(ROOT / file)
        rings = [*nx.bfs_layers(self._imports, [module])] if module in self._imports else []
        away = {name: distance for distance, ring in enumerate(rings) for name in ring}
        near, far = ([_module(path) for path in folder.rglob("test_*.py")] for folder in (ROOT / named).parents[:2])
        found = dict.fromkeys([str(named)] if _module(ROOT / named) in self._imports else [])
        for ring in (*rings[:2], near, *rings[2:], far):
            tests = [name for name in ring if name.startswith("tests.") and ".test_" in name and name in self._imports]
            tests.sort(key=lambda name: (name not in near, away.get(name, 99), self._imports.in_degree(name), name))
            found |= dict.fromkeys(f"{name.replace('.', '/')}.py" for name in tests)
        return list(found)[:MOST]


def _module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts if parts[0] == "tests" else ("proofmass", *parts)).removesuffix(".__init__")


def _imported(path: Path) -> Iterator[str]:
    """Yield the names that a file imports, by their form: syntax trees of a thousand files take ten seconds."""
    for module, names, alone in _IMPORT.findall(path.read_text(encoding="utf-8")):
        yield module or alone
        yield from (f"{module}.{name}" for name in re.findall(r"(\w+)(?: as \w+)?", names))


def dealt(seconds: Mapping[str, float], name: str, budget: float, most: int) -> list[str]:
    """Return tests of the file of a name, then one of every file in turn, the quicker ones first; then by file.

    They take the `budget` of seconds, and come from so many files at most.
    """
    files = dict[str, list[str]]()
    for test in sorted(seconds, key=seconds.__getitem__):
        files.setdefault(test.partition("::")[0], []).append(test)
    near = [test for file in [*files] if Path(file).stem == f"test_{name}" for test in files.pop(file)]
    rounds = itertools.chain(*itertools.zip_longest(*files.values()))
    tests, left = dict[str, list[str]](), budget
    for test in (*near, *filter(None, rounds)):
        file = test.partition("::")[0]
        if not tests or (seconds[test] <= left and (file in tests or len(tests) < most)):
            tests.setdefault(file, []).append(test)
            left -= seconds[test]
    return [test for chosen in tests.values() for test in chosen]
