"""Places in its file where a block declares something."""

import ast
import inspect
from functools import lru_cache
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem


def problem(kind: type[Block], name: str, message: str, **more: Any) -> Problem:
    """Return a problem of what a block calls `name`, with file and line; "" is the block itself."""
    key = f"{kind.__name__}.{name}" if name else kind.__name__
    try:
        file = inspect.getsourcefile(kind) or ""
        lines = _lines(Path(file).read_text(encoding="utf-8"), kind.__name__)
    except (OSError, TypeError, SyntaxError):
        return Problem(message=message, key=key, **more)
    return Problem(message=message, key=key, file=file, line=lines.get(name, lines.get("", 0)), **more)


@lru_cache(maxsize=64)
def _lines(text: str, kind: str) -> dict[str, int]:
    """The line of each parameter, port and function of a block, and under "" that of its class."""
    lines: dict[str, int] = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.ClassDef) and node.name == kind:
            lines[""] = node.lineno
            for part in node.body:
                targets = part.targets if isinstance(part, ast.Assign) else [getattr(part, "target", None)]
                lines |= {target.id: part.lineno for target in targets if isinstance(target, ast.Name)}
        if isinstance(node, ast.FunctionDef) and any(_is_of(kind, part) for part in node.decorator_list):
            lines[node.name] = node.lineno
    return lines


def _is_of(kind: str, decorator: ast.expr) -> bool:
    return any(isinstance(node, ast.Name) and node.id == kind for node in ast.walk(decorator))
