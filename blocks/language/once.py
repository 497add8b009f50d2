"""Text of what functions of a user's own block do that run once a sensor: equal where all sensors are.

A program holds what is done in each tick; what `constants`, `start` and requirements do shows in
the numbers of the sensors that are tried alone.
"""

import ast
import types
from collections.abc import Iterator
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.source import SourceError, tree_of
from proofmass.blocks.language.forms import LOOPED, is_own, looked_up, plain
from proofmass.blocks.language.scope import MISSING


def text_of_once(kind: type[Block]) -> str:
    """Return these functions of a block, what they call and read, and the bounds of its parameters.

    It is empty for the blocks of the library. Words, names of files and places in them are left out.
    """
    if not is_own(kind):
        return ""
    looped = () if kind.has_formats() else LOOPED  # functions on words are traced for each sensor
    functions = [plain(behaviour) for name, behaviour in kind.functions.items() if name not in looped]
    functions += [plain(behaviour) for behaviour in kind.output_functions.values() if kind.has_formats()]
    lines = [f"{name} {parameter.bounds()}" for name, parameter in kind.parameters.items()]
    left: list[Any] = [*functions, kind.requirements]
    visited = set[types.FunctionType]()
    while left:
        here = left.pop()
        if not isinstance(here, types.FunctionType) or here in visited or here.__module__.startswith("proofmass."):
            continue
        visited.add(here)
        try:
            tree = tree_of(here)
        except SourceError:
            lines.append(repr((here.__code__.co_code, here.__code__.co_names)))
            continue
        lines.append("\n".join(map(ast.unparse, _without_words(tree))))
        for node in ast.walk(tree):
            value = looked_up(here, node) if isinstance(node, ast.Name | ast.Attribute) else MISSING
            if isinstance(value, types.FunctionType):
                left.append(value)
            elif isinstance(value, type) and value.__module__ == here.__module__:  # a record, say
                lines.append(f"{value.__qualname__}: {value.__annotations__}")
                left += vars(value).values()
            elif value is not MISSING:
                lines.append(f"{ast.unparse(node)} = {_told(value)}")
    return "\n".join(sorted(lines))


def _without_words(tree: ast.FunctionDef) -> Iterator[ast.AST]:
    yield tree.args
    yield from tree.body[ast.get_docstring(tree) is not None :]


def _told(value: Any) -> str:
    """Return data as text; of other objects their kind alone, since their texts have places in memory."""
    match value:
        case None | bool() | int() | float() | complex() | str() | bytes():
            return repr(value)
        case tuple() | list():
            return f"[{', '.join(map(_told, value))}]"
        case dict():
            return f"{{{', '.join(f'{_told(key)}: {_told(entry)}' for key, entry in value.items())}}}"
        case set() | frozenset():
            return f"{{{', '.join(sorted(map(_told, value)))}}}"
        case _ if hasattr(value, "tolist"):
            return _told(value.tolist())
        case _:
            return getattr(value, "__qualname__", type(value).__qualname__)
