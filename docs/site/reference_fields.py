"""The fields of a public class with their types, and the comments after them in its source or the words of a key."""

import ast
import inspect
import textwrap
from typing import Any, NamedTuple


class Field(NamedTuple):
    """A field of a class: what it is called, its type, and what it is, with its unit."""

    name: str
    type: str
    meaning: str


def fields(kind: type[Any]) -> list[Field]:
    """Return the public fields of a class and of the classes that it extends, in their order."""
    own = [part for part in reversed(kind.__mro__) if part.__module__.startswith("proofmass.")]
    return [field for part in own for field in _fields(part)]


def _fields(kind: type[Any]) -> list[Field]:
    source = textwrap.dedent(inspect.getsource(kind))
    lines = source.splitlines()
    tree = ast.parse(source).body[0]
    assert isinstance(tree, ast.ClassDef)
    return [
        Field(node.target.id, ast.unparse(node.annotation), _comment(lines, node) or _key(kind, node.target.id))
        for node in tree.body
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and not _hidden(node)
    ]


def _key(kind: type[Any], name: str) -> str:
    """Return what a field that is a key of graph files means."""
    field = getattr(kind, "__dataclass_fields__", {}).get(name)
    return str(field.metadata.get("meaning", "")) if field else ""


def _hidden(node: ast.AnnAssign) -> bool:
    """Return whether a field is private, or belongs to the class and not to its values."""
    assert isinstance(node.target, ast.Name)
    return node.target.id.startswith("_") or "ClassVar" in ast.unparse(node.annotation)


def _comment(lines: list[str], node: ast.AnnAssign) -> str:
    """Return the comment in the lines of a field, or at their end."""
    assert node.end_lineno is not None
    texts = [line.partition("  # ")[2] for line in lines[node.lineno - 1 : node.end_lineno]]
    return " ".join(filter(None, texts)).strip()
