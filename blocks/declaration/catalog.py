"""The table of all blocks by name, and one block's facts as data."""

import ast
import importlib
import importlib.util
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.families import homes
from proofmass.blocks.declaration.other_names import other_names
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.declaration.source import remember

Own = Mapping[str, type[Block]]
OWN = "proofmass_own_"  # name of the modules of a user's own blocks


def find(kind: str, own: Own | None = None) -> type[Block] | None:
    """The block class of a name, imported alone; None when there is none."""
    if own and kind in own:
        return own[kind]
    module = homes().get(kind.lower())
    found = getattr(importlib.import_module(f"proofmass.blocks.{module}"), kind, None) if module else None
    return found if isinstance(found, type) and issubclass(found, Block) and found is not Block else None


def all_blocks(own: Own | None = None) -> dict[str, type[Block]]:
    """Every block class by name, in alphabetical order."""
    found: dict[str, type[Block]] = dict(own or {})
    for module in homes().values():
        found |= _blocks_of(importlib.import_module(f"proofmass.blocks.{module}"))
    return dict(sorted(found.items()))


def load_own_blocks(path: Path) -> dict[str, type[Block]]:
    """Return the blocks that a user's Python file declares; the file is run, so only the caller may name it.

    Raises `ModelError` if one has the name of a library block, and any error that the file raises.
    """
    name = f"{OWN}{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    text = path.read_text(encoding="utf-8")
    remember(str(module.__file__), text)
    exec(compile(text, str(module.__file__), "exec"), module.__dict__)  # bytecode on disk may belong to an older text
    kinds = _blocks_of(module)
    taken = [kind for kind in kinds if find(kind) is not None]
    if taken:
        lines = {node.name: node.lineno for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ClassDef)}
        raise ModelError([_taken(path, kind, lines.get(kind, 0)) for kind in taken])
    return kinds


def _taken(path: Path, kind: str, line: int) -> Problem:
    hint = f"call it otherwise, for example My{kind}"
    return Problem(message="the library has a block of this name", file=str(path), line=line, key=kind, hint=hint)


def own_file(kind: type[Block]) -> Path | None:
    """The user's file that a block was loaded from; None for blocks from elsewhere."""
    module = sys.modules.get(kind.__module__)
    return Path(str(module.__file__)) if module and kind.__module__.startswith(OWN) else None


def family_of(kind: type[Block]) -> str:
    """The family of a block of the library, "own" of any other.

    >>> family_of(find("Gain"))
    'signals'
    """
    parts = kind.__module__.split(".")
    return parts[2] if parts[:2] == ["proofmass", "blocks"] and len(parts) == 4 else "own"


def family_about(family: str) -> str:
    """Return the description of a family, the docstring of its folder."""
    if family == "own":
        return "Blocks of your own file."
    return (sys.modules[f"proofmass.blocks.{family}"].__doc__ or "").strip()


def facts(kind: type[Block]) -> dict[str, Any]:
    """Return the declaration of a block as plain data."""
    return {
        "kind": kind.__name__,
        "family": family_of(kind),
        "doc": (kind.__doc__ or "").strip(),
        "elsewhere": other_names(kind.__name__) if family_of(kind) != "own" else [],
        "equation": (sys.modules[kind.__module__].__doc__ or "").strip(),
        "continuous": kind.continuous(),
        "parameters": {name: _parameter(p) for name, p in kind.parameters.items()},
        "inputs": {name: _port(p) for name, p in kind.inputs.items()},
        "outputs": {name: _port(p) | {"feedthrough": list(kind.feedthrough(name))} for name, p in kind.outputs.items()},
    }


def _parameter(p: Parameter) -> dict[str, Any]:
    kind = {tuple: "list", Fixed: "format"}.get(p.kind, p.kind.__name__)
    default = list(p.default) if p.kind is tuple else str(p.default) if p.kind is Fixed else p.default
    data: dict[str, Any] = {"type": kind, "unit": p.unit, "doc": p.doc, "default": default}
    bounds = {n: getattr(p, n) for n in ("above", "at_least", "below", "at_most") if getattr(p, n) is not None}
    return data | bounds | ({"choices": list(p.choices)} if p.choices else {})


def _port(p: Port) -> dict[str, Any]:
    data: dict[str, Any] = {
        "type": "fixed" if p.dtype is FixedValue else p.dtype.__name__,
        "unit": p.unit,
        "doc": p.doc,
    }
    if p.shape:
        data["shape"] = [size if isinstance(size, int | str) else "derived" for size in p.shape]
    if p.every != 1:
        data["every"] = p.every if isinstance(p.every, int | str) else "derived"
    if p.default is not None:
        data["default"] = p.default
    return data


def _blocks_of(module: Any) -> dict[str, type[Block]]:
    found = (v for v in vars(module).values() if isinstance(v, type) and issubclass(v, Block) and v is not Block)
    return {kind.__name__: kind for kind in found if kind.__module__ == module.__name__}
