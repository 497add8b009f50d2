"""No file of the runner changes what belongs to a module or a class: analyses run side by side in threads.

Excepted are caches whose keys say all that their values follow from.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import proofmass.runner

RUNNER = Path(next(iter(proofmass.runner.__path__)))
CHANGES = {"append", "add", "update", "setdefault", "pop", "clear", "extend", "remove", "insert", "discard", "popitem"}
CHANGING = (ast.Assign, ast.AugAssign, ast.AnnAssign, ast.Delete)
CACHES = {
    ("live/carried.py", "_modules"),  # WebAssembly by its text
    ("plan/recording.py", "_kept"),  # recordings by path and time of change
    ("program/shared.py", "_known"),  # sizes by function
    ("rtl/model/cxxrtl.py", "_opened"),  # libraries by the hash of their source
    ("run/engines.py", "_spent"),  # seconds that compiling took, by plan: they choose an engine, and no bit
    ("targets/machine_code.py", "_loaded"),  # machine code by the hash of its text
}


def changed(source: str) -> Iterator[str]:
    """Yield the names of a module that its functions change."""
    tree = ast.parse(source)
    own = {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
    for node in tree.body:
        targets = [node.target] if isinstance(node, ast.AnnAssign) else getattr(node, "targets", [])
        own |= {target.id for target in targets if isinstance(target, ast.Name)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Global):
            yield from node.names
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            if node.func.attr in CHANGES and isinstance(node.func.value, ast.Name) and node.func.value.id in own:
                yield node.func.value.id
        elif isinstance(node, CHANGING):
            for target in getattr(node, "targets", None) or [getattr(node, "target", None)]:
                for one in target.elts if isinstance(target, ast.Tuple | ast.List) else [target]:
                    place = one.value if isinstance(one, ast.Attribute | ast.Subscript) else None
                    if isinstance(place, ast.Name) and place.id in own:
                        yield place.id


def test_a_change_is_found() -> None:
    text = "class Latest:\n    plan = None\n\nseen = []\n\ndef f(x):\n    Latest.plan = x\n    seen.append(x)\n"
    assert sorted(changed(text)) == ["Latest", "seen"]


def test_no_module_of_the_runner_has_state() -> None:
    found = {
        (str(path.relative_to(RUNNER)), name) for path in RUNNER.rglob("*.py") for name in changed(path.read_text())
    }
    assert found == CACHES
