"""The source itself: nothing evaluates, unpickles or imports what a file names, but at the known places."""

import ast
import re
import unicodedata
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted(file for folder in ("blocks", "graphs", "runner") for file in (ROOT / folder).rglob("*.py"))

FORBIDDEN_MODULES = {
    "pickle",
    "cPickle",
    "marshal",
    "shelve",
    "yaml",
    "dill",
    "cloudpickle",
    "joblib",
    "code",
    "codeop",
}
FORBIDDEN_CALLS = {"eval", "__import__", "execfile", "breakpoint", "input"}
FORBIDDEN_METHODS = {("os", "system"), ("os", "popen"), ("builtins", "exec")}
SUSPECT = re.compile(  # whatever is refused has one of these in its text
    rf"\b(import|from)\b(\\\n|[^\n])*\b({'|'.join(FORBIDDEN_MODULES)})\b"
    rf"|\b({'|'.join(FORBIDDEN_CALLS)}|exec|compile|popen|system)\b([\s\\)]|#[^\n]*)*\("
    r"|\b(builtins|exec_module|importlib|from[\s\\]+os|shell|allow_pickle)\b"
)

# Where a name may run: the block catalog imports blocks and the caller's own file; functions of own blocks are written
# anew from their own trees, integer code from what was traced, and files are compiled to tell functions apart, which
# runs nothing.
KNOWN = {
    ("blocks/declaration/catalog.py", "find", "importlib.import_module"),
    ("blocks/declaration/catalog.py", "all_blocks", "importlib.import_module"),
    ("blocks/declaration/catalog.py", "load_own_blocks", "importlib.util.spec_from_file_location"),
    ("blocks/declaration/catalog.py", "load_own_blocks", "importlib.util.module_from_spec"),
    ("blocks/declaration/catalog.py", "load_own_blocks", "compile"),
    ("blocks/declaration/catalog.py", "load_own_blocks", "exec"),
    ("blocks/declaration/source.py", "define", "exec"),
    ("blocks/declaration/source.py", "define", "compile"),
    ("blocks/declaration/source.py", "_definitions", "compile"),
    ("blocks/declaration/source.py", "_alone", "compile"),
}


def dotted(node: ast.expr) -> str:
    """The name of what is called, as in "os.path.join"; empty for anything else."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return ""


def calls(tree: ast.AST, function: str = "") -> Iterator[tuple[str, ast.Call]]:
    """Every call, with the function that it stands in."""
    for node in ast.iter_child_nodes(tree):
        inner = node.name if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) else function
        if isinstance(node, ast.Call):
            yield inner, node
        yield from calls(node, inner)


def faults(source: str, file: str) -> list[str]:
    """Everything in a source that must not be there; parsed only if its text has such words."""
    found = list[str]()
    if not SUSPECT.search(unicodedata.normalize("NFKC", source)):  # as the parser reads names
        return found
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if not isinstance(node, ast.Import | ast.ImportFrom):
            continue
        imported = [alias.name for alias in node.names]
        if isinstance(node, ast.ImportFrom):
            imported = [node.module or "", *(f"{node.module}.{name}" for name in imported)]
        found += [f"{file}:{node.lineno}: import {name}" for name in imported if _module_is_forbidden(name)]
    for function, call in calls(tree):
        name = dotted(call.func)
        last_two = tuple(name.split(".")[-2:])
        runs = name in ("exec", "compile") or name.startswith("importlib.") or name.endswith("exec_module")
        known = (file, function, name) in KNOWN
        shell = any(k.arg == "shell" and not _is_false(k.value) for k in call.keywords)
        unpickles = any(k.arg == "allow_pickle" and not _is_false(k.value) for k in call.keywords)
        if name in FORBIDDEN_CALLS or last_two in FORBIDDEN_METHODS or (runs and not known) or shell or unpickles:
            found.append(f"{file}:{call.lineno}: {name} in {function or 'the module'}")
    return found


def _module_is_forbidden(name: str) -> bool:
    return name.split(".")[0] in FORBIDDEN_MODULES or name in (
        "os.system",
        "os.popen",
        "builtins.eval",
        "builtins.exec",
    )


def _is_false(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is False


def test_the_three_folders_are_scanned() -> None:
    assert len(SOURCES) > 40
    assert {file.relative_to(ROOT).parts[0] for file in SOURCES} == {"blocks", "graphs", "runner"}


@pytest.mark.parametrize("room", ["blocks", "graphs", "runner"])
def test_nothing_runs_what_a_file_names(room: str) -> None:
    names = {str(file.relative_to(ROOT)): file for file in SOURCES if file.is_relative_to(ROOT / room)}
    assert [fault for name, file in names.items() for fault in faults(file.read_text(encoding="utf-8"), name)] == []


@pytest.mark.exhaustive
def test_the_known_places_are_there() -> None:
    there = set()
    for file in SOURCES:
        name = str(file.relative_to(ROOT))
        there |= {(name, function, dotted(call.func)) for function, call in calls(ast.parse(file.read_text("utf-8")))}
    assert there >= KNOWN


@pytest.mark.parametrize(
    "source",
    [
        "eval('1')",
        "exec('1')",
        "x = compile('1', '', 'eval')",
        "__import__('os')",
        "import pickle",
        "import marshal as m",
        "from pickle import loads",
        "from os import system",
        "import os\nos.system('true')",
        "import yaml",
        "import subprocess\nsubprocess.run('true', shell=True)",
        "import numpy as np\nnp.load('x.npy', allow_pickle=True)",
        "import importlib\nimportlib.import_module('os')",
        "class A:\n    def f(self):\n        return eval('1')",
        "import builtins\nbuiltins.exec('1')",
    ],
)
def test_the_scan_finds_what_it_looks_for(source: str) -> None:
    assert faults(source, "runner/some.py")


@pytest.mark.parametrize(
    "source", ["import re\nre.compile('a')", "numba.njit(f)", "text.format(1)", "np.load('x.npy')"]
)
def test_the_scan_passes_what_is_harmless(source: str) -> None:
    assert faults(source, "runner/some.py") == []
