"""Trees of functions: from their own lines as from their whole file, and never of another text than the loaded one."""

import ast
import importlib.util
import inspect
import linecache
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks.declaration import source
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.source import SourceError, tree_of


def functions() -> Iterator[types.FunctionType]:
    """Every function that is written in a module of blocks, those of classes too."""
    all_blocks()
    for name, module in list(sys.modules.items()):
        if name.startswith("proofmass.blocks."):
            owners = [module, *(kind for kind in vars(module).values() if isinstance(kind, type))]
            for owner in owners:
                written = [f for name, f in vars(owner).items() if not name.startswith("__annotate")]  # Python 3.14's
                found = (inspect.unwrap(f) for f in written if isinstance(f, types.FunctionType))
                yield from (f for f in found if f.__module__ == name and f.__code__.co_filename == module.__file__)


@pytest.mark.exhaustive
def test_own_lines_give_the_tree_that_the_whole_file_gives() -> None:
    short = 0
    for function in set(functions()):
        text, code = "".join(inspect.findsource(function)[0]), function.__code__
        whole = source._definitions(text, code.co_filename)[code.co_firstlineno, code.co_name]
        own = source._alone(text, code)
        short += own is not None
        if own is not None:
            assert ast.dump(own[0], include_attributes=True) == ast.dump(whole[0], include_attributes=True), function
    assert short > 500  # the others, with functions inside, take the whole file


def loaded(file: Path, text: str) -> Any:
    """The module of a text that is written to a file."""
    file.write_text(text)
    linecache.checkcache(str(file))
    spec = importlib.util.spec_from_file_location(f"of_{file.stem}", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    exec(compile(text, str(file), "exec"), vars(module))
    return module


SHAPES = {
    "plain": "def f(x):\n    return x + 1.0\n",
    "a signature over lines": "def f(\n    x,\n    y=2.0,\n) -> float:\n    return x + y\n\n\nLATER = 1\n",
    "a text that is less indented": 'def f(x):\n    """One\ntwo.\n    """\n    return x\nLATER = 1\n',
    "nothing but a text": 'def f(x):\n    """One."""\n\n\nLATER = 1\n',
    "an end that does nothing": "def f(x):\n    if x:\n        return 1\n    else:\n        pass\n",
    "decorated": "import functools\n\n\n@functools.cache\n@functools.cache\ndef f(x):\n    return x\n",
    "in a class": "class A:\n    @staticmethod\n    def f(x):\n        return x\n\n    g = 1\n\n\nf = A.f\n",
    "with names that a class changes": "class A:\n    def f(self):\n        return self.__own\n\n\nf = A.f\n",
    "within a function": "def made(y):\n    def f(x):\n        return x + y\n    return f\n\n\nf = made(1.0)\n",
    "with a function within": "def f(x):\n    g = lambda y: y + x\n    return g(x)\n",
    "of future annotations": "from __future__ import annotations\n\n\ndef f(x: Nothing) -> Nothing:\n    return x\n",
    "a lambda": "f = lambda x: x + 1.0\n",
    "with a comment at its end": "def f(x):\n    return x\n    # the end\n# behind\nLATER = 1\n",
    "in brackets": "def f(x):\n    return (\n        x\n        + 1.0\n    )\n",
}


@pytest.mark.parametrize("text", SHAPES.values(), ids=SHAPES)
def test_the_tree_is_the_definition(text: str, tmp_path: Path) -> None:
    function = inspect.unwrap(loaded(tmp_path / "shape.py", text).f)
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef) and node.name == "f"]
    tree = tree_of(function)
    if not nodes:
        (node,) = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Lambda))
        assert ast.dump(tree.body[0]) == ast.dump(ast.Return(node.body))
        return
    assert ast.dump(tree, include_attributes=True) == ast.dump(nodes[0], include_attributes=True)


CHANGES = {
    "a number": ("def f(x):\n    return x + 1.0\n", "def f(x):\n    return x + 2.0\n"),
    "a name": ("def f(x):\n    return abs(x)\n", "def f(x):\n    return int(x)\n"),
    "a number of a function within": (
        "def f(x):\n    g = lambda y: y * 2.0\n    return g(x)\n",
        "def f(x):\n    g = lambda y: y * 3.0\n    return g(x)\n",
    ),
    "a line above": ("def f(x):\n    return x\n", "A = 1\ndef f(x):\n    return x\n"),
    "all of it": ("def f(x):\n    return x\n", ""),
    "half of it": ("def f(x):\n    return (x +\n        1.0)\n", "def f(x):\n    return (x +\n"),
}


@pytest.mark.parametrize(("before", "after"), CHANGES.values(), ids=CHANGES)
def test_a_file_that_changed_is_refused(before: str, after: str, tmp_path: Path) -> None:
    module = loaded(tmp_path / "changed.py", before)
    (tmp_path / "changed.py").write_text(after)
    linecache.clearcache()
    with pytest.raises(SourceError):
        tree_of(module.f)
