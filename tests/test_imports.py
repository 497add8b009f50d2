"""The house: imports make no circle, not of files and not of folders, those inside functions included."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import networkx as nx
import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("blocks", "graphs", "runner")


def modules() -> dict[str, Path]:
    """Every module of the package with its file; what `new` writes for users is none."""
    files = [file for room in ROOMS for file in (ROOT / room).rglob("*.py") if "library" not in file.parts]
    named = {f"proofmass.{'.'.join(file.relative_to(ROOT).with_suffix('').parts)}": file for file in files}
    named |= {f"proofmass.{file.stem}": file for file in (ROOT / "src" / "proofmass").glob("*.py")}
    return {name.removesuffix(".__init__"): file for name, file in named.items()}


MODULES = modules()


@cache
def nodes(module: str) -> tuple[ast.AST, ...]:
    """All statements of a module, and what stands between them; no expression holds an import."""
    below: list[ast.AST] = [ast.parse(MODULES[module].read_text(encoding="utf-8"))]
    for node in below:
        below += [child for child in ast.iter_child_nodes(node) if not isinstance(child, ast.expr)]
    return tuple(below)


def imported(module: str) -> Iterator[str]:
    """Modules of the package that a module imports anywhere in its text."""
    for node in nodes(module):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in MODULES)
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name if name in MODULES else str(node.module) for name in names)


@cache
def arrows() -> "nx.DiGraph[str]":
    """The imports between modules."""
    graph = nx.DiGraph()
    graph.add_nodes_from(MODULES)
    graph.add_edges_from((module, other) for module in MODULES for other in imported(module) if other in MODULES)
    return graph


def circles(graph: "nx.DiGraph[str]") -> list[list[str]]:
    return [sorted(together) for together in nx.strongly_connected_components(graph) if len(together) > 1]


@pytest.mark.exhaustive
def test_no_file_imports_itself_by_way_of_others() -> None:
    assert circles(arrows()) == []


@pytest.mark.exhaustive
def test_no_folder_imports_itself_by_way_of_others() -> None:
    folders = {module: str(file.parent.relative_to(ROOT)) for module, file in MODULES.items()}
    between = nx.DiGraph()
    between.add_edges_from((folders[a], folders[b]) for a, b in arrows().edges if folders[a] != folders[b])
    assert circles(between) == []


def test_nothing_imports_the_root_package_or_the_start_of_the_program() -> None:
    named = re.compile(r"\bimport proofmass\b|\bfrom proofmass import|\bproofmass\.__main__\b")
    asked = [module for module, file in MODULES.items() if named.search(file.read_text(encoding="utf-8"))]
    starts = {module: {"proofmass", "proofmass.__main__"} & {*imported(module)} for module in asked}
    assert {module: own for module, own in starts.items() if own} == {}


def imports_without_a_reason(text: str) -> list[int]:
    """Lines of imports inside functions with no comment in that line or above; the first of several speaks for all."""
    if not re.search(r"(?:^[ \t]+|[:;][ \t]*)(?:import|from)\b", text, re.MULTILINE):
        return []
    lines = text.splitlines()
    functions = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    inside = {node for function in functions for node in ast.walk(function)}
    silent, before = [], 0
    for node in sorted((n for n in inside if isinstance(n, ast.Import | ast.ImportFrom)), key=lambda n: n.lineno):
        commented = "#" in lines[node.lineno - 1] or lines[node.lineno - 2].lstrip().startswith("#")
        if not commented and node.lineno != before + 1:
            silent.append(node.lineno)
        before = node.end_lineno or node.lineno
    return silent


@pytest.mark.exhaustive
def test_an_import_inside_a_function_says_why() -> None:
    silent = {
        f"{file.relative_to(ROOT)}:{line}"
        for file in MODULES.values()
        for line in imports_without_a_reason(file.read_text(encoding="utf-8"))
    }
    assert silent == set()


def test_the_reason_is_in_the_line_or_above() -> None:
    said = "def f():\n    # start-up time\n    import a\n    import b\n\n    import c  # optional\n"
    assert imports_without_a_reason(said) == []
    assert imports_without_a_reason("import a\n\ndef f():\n    x = 1\n    import b\n") == [5]


CLIMBING = {
    "blocks/signals/gain.py": "proofmass.blocks.filters.low_pass",
    "blocks/declaration/units.py": "proofmass.graphs.model.rates",
    "graphs/model/rates.py": "proofmass.graphs.studies.study",
    "graphs/drawing/layers.py": "proofmass.graphs.files.toml_reader",
    "runner/plan/keys.py": "proofmass.runner.run.result",
    "runner/rtl/machine/words.py": "proofmass.runner.rtl.bench.cost",
    "runner/studies/outcome/intervals.py": "proofmass.runner.studies.whole.study",
    "runner/analysis/linearisation/poles.py": "proofmass.runner.analysis.margins.margins",
}


@pytest.mark.exhaustive
def test_the_contracts_see_imports_that_climb(tmp_path: Path) -> None:
    """A copy of the package with some lines more, each of which a contract of import-linter must refuse."""
    pytest.importorskip("importlinter")
    (tmp_path / "proofmass").mkdir()
    (tmp_path / "proofmass" / "__init__.py").write_text("")
    for file in (file for name in ROOMS for file in (ROOT / name).rglob("*.py")):
        path = file.relative_to(ROOT)
        copy = tmp_path / "proofmass" / path
        copy.parent.mkdir(parents=True, exist_ok=True)
        more = f"\nimport {CLIMBING[str(path)]}\n" if str(path) in CLIMBING else ""
        copy.write_text(file.read_text(encoding="utf-8") + more)
    (tmp_path / "pyproject.toml").write_text((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"]
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120).stdout
    refused = " ".join(told.split())
    for path, climbs in CLIMBING.items():
        assert f"{'.'.join(('proofmass', *Path(path).with_suffix('').parts))} -> {climbs}" in refused
