"""Names of a function: its variables with their types, and the values it reads from outside."""

import ast
import builtins
import types
from typing import Any

from proofmass.blocks.declaration.problem import did_you_mean, nearest
from proofmass.blocks.language.refusals import refuse
from proofmass.blocks.language.values import RefusedType, Type

MISSING = object()
Read = tuple[types.FunctionType | types.ModuleType | type, str, Any]


class Scope:
    """Variables and outer values of one function; made-up names begin unlike all of its names."""

    def __init__(
        self, function: types.FunctionType, tree: ast.FunctionDef, arguments: dict[str, Type], promoted: set[str]
    ) -> None:
        self.function = function
        self.types: dict[str, Type] = dict(arguments)
        self.assigned = set(arguments)  # variables that surely have a value at this point
        self.promoted = promoted  # variables that are numbers, though integers are assigned to them
        self.namespace: dict[str, Any] = {}
        self.reads: list[Read] = []  # values from outside, to see later whether they have changed
        self._locals = set(function.__code__.co_varnames) | set(function.__code__.co_cellvars)
        used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)} | self._locals
        self.prefix = "_"
        while any(name.startswith(self.prefix) for name in used):
            self.prefix += "_"
        self._count = 0

    def fresh(self) -> str:
        """A new variable."""
        self._count += 1
        return f"{self.prefix}{self._count}"

    def bind(self, value: Any) -> str:
        """The name by which the function knows a value."""
        for name, known in self.namespace.items():
            if known is value:
                return name
        plain = getattr(getattr(value, "value", value), "__name__", "table")
        name = f"{self.prefix}{plain if plain.isidentifier() else 'function'}"
        while name in self.namespace:
            name += "_"
        self.namespace[name] = value
        return name

    def local(self, node: ast.Name) -> Type | None:
        """The type of a variable; None for one from outside. Refuses one without a sure value."""
        if node.id in self.assigned:
            return self.types[node.id]
        if node.id not in self._locals:
            return None
        if isinstance(self.types.get(node.id), RefusedType):
            return RefusedType()
        raise refuse(node, f"{node.id} may have no value here", f"give it one before: {node.id} = 0.0")

    def outside(self, node: ast.Name) -> Any:
        """A value from outside of the function."""
        value = outer(self.function, node.id)
        if value is MISSING:
            near = nearest(node.id, self.types) or nearest(node.id, self.function.__globals__)
            raise refuse(node, f"there is no {node.id}", f"did you mean {near}?" if near else "define or import it")
        self.reads.append((self.function, node.id, value))
        return value

    def member(self, node: ast.Attribute, owner: Any) -> Any:
        """A value of a module."""
        value = getattr(owner, node.attr, MISSING)
        if isinstance(owner, type) and not isinstance(value, int | float | tuple):  # numbers of a class, of an Enum
            raise refuse(node, f"{ast.unparse(node)} is not compiled", "write it with numbers")
        if value is MISSING:
            name = getattr(owner, "__name__", "it")
            names = [each for each in dir(owner) if not each.startswith("_")]
            raise refuse(node, f"{name} has no {node.attr}", did_you_mean(node.attr, names, f"the names of {name}"))
        self.reads.append((owner, node.attr, value))
        return value


def unchanged(reads: list[Read]) -> bool:
    """Return whether values from outside are the same as when they were read."""
    return all(_same(_now(owner, name), value) for owner, name, value in reads)


def _now(owner: Any, name: str) -> Any:
    return outer(owner, name) if isinstance(owner, types.FunctionType) else getattr(owner, name, MISSING)


def _same(value: Any, before: Any) -> bool:
    return value is before or (
        type(value) is type(before) and isinstance(value, int | float | tuple) and value == before
    )


def outer(function: types.FunctionType, name: str) -> Any:
    """Return a value that a function reads from outside, or MISSING."""
    for free, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        if free == name:
            return cell.cell_contents
    return function.__globals__.get(name, getattr(builtins, name, MISSING))
