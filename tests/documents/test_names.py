"""One public name, one meaning: no two modules define a class or a type of the same name."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
OF_A_BLOCK = {"State", "Constants"}  # every block may have its own
READ_LOOSELY = {"Graph", "Study"}  # the class that reads loose values makes one of the checked class of that name


def named(path: Path) -> Iterator[str]:
    """Public classes and aliases of types that a file defines at its top level."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        match node:
            case ast.ClassDef(name=name):
                yield name
            case ast.Assign(targets=[ast.Name(id=name)]) if name[:1].isupper() and not name.isupper():
                yield name
            case ast.AnnAssign(target=ast.Name(id=name), value=ast.expr()) if name[:1].isupper() and not name.isupper():
                yield name


def homes() -> dict[str, list[str]]:
    found = defaultdict(list)
    for room in ("blocks", "graphs", "runner"):
        for path in sorted((ROOT / room).rglob("*.py")):
            for name in named(path):
                found[name].append(str(path.relative_to(ROOT)))
    return found


def test_each_public_class_has_one_meaning() -> None:
    every = {name: files for name, files in homes().items() if not name.startswith("_")}
    assert {"MassSpringDamper", "Linearisation", "Array", "Moving"} <= every.keys(), "classes and aliases are found"
    twice = {name: files for name, files in every.items() if len(files) > 1 and name not in OF_A_BLOCK | READ_LOOSELY}
    assert twice == {}
