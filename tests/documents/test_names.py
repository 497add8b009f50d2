"""One public name, one meaning: no two modules define a class or a type of the same name."""

import ast
import re
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
OF_A_BLOCK = {"State", "Constants"}  # every block may have its own
FOUND = {"MassSpringDamper", "Linearisation", "Array", "Moving"}
BEGUN = re.compile(r"^(class[ \t]+)?((?!_)\w+)(?=[ \t]*[:=(\[])", re.MULTILINE)
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


def begun_by(text: str) -> set[str]:
    """What begins a line of a text and may be the public name of a class or a type."""
    return {name for of_class, name in BEGUN.findall(text) if of_class or (name[:1].isupper() and not name.isupper())}


def homes() -> dict[str, list[str]]:
    """Files that define a name; read through are those that begin a line with what another does too, or `FOUND`."""
    paths = [path for room in ("blocks", "graphs", "runner") for path in sorted((ROOT / room).rglob("*.py"))]
    begun = {path: begun_by(path.read_text(encoding="utf-8")) - OF_A_BLOCK - READ_LOOSELY for path in paths}
    files = Counter(name for names in begun.values() for name in names)
    found = defaultdict(list)
    for path in (path for path, names in begun.items() if names & FOUND or any(files[name] > 1 for name in names)):
        for name in named(path):
            found[name].append(str(path.relative_to(ROOT)))
    return found


def test_each_public_class_has_one_meaning() -> None:
    every = {name: files for name, files in homes().items() if not name.startswith("_")}
    assert every.keys() >= FOUND, "classes and aliases are found"
    twice = {name: files for name, files in every.items() if len(files) > 1 and name not in OF_A_BLOCK | READ_LOOSELY}
    assert twice == {}
