"""No block calls the C library for a number: its last bits differ from machine to machine."""

import ast
import inspect
import math
import pkgutil
from collections.abc import Iterator
from importlib import import_module
from types import ModuleType
from typing import Any

import pytest

import proofmass.blocks
from proofmass.blocks.declaration.catalog import all_blocks

CONSTANTS = {name for name, value in vars(math).items() if isinstance(value, float)}
EXACT = {
    *("sqrt", "floor", "ceil", "trunc", "fabs", "copysign", "ldexp", "frexp", "isfinite", "isinf", "isnan"),
    *("prod", "gcd", "lcm", "comb", "isqrt", "ulp"),
}  # the same bits everywhere
OTHERS = {"declaration", "language"}  # of blocks, but run in no tick
ROOM = "proofmass.blocks"


def modules() -> Iterator[str]:
    for entry in pkgutil.walk_packages(proofmass.blocks.__path__, f"{ROOM}."):
        if entry.name.split(".")[2] not in OTHERS:
            yield entry.name


def calls(source: str, integers: frozenset[str] = frozenset()) -> list[str]:
    """What a module takes from the C library; `integers` are parameters of its block."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "math":
            if node.attr not in EXACT | CONSTANTS:
                found.append(f"line {node.lineno}: math.{node.attr}")
        elif isinstance(node, ast.ImportFrom) and node.module in ("math", "cmath"):
            found.append(f"line {node.lineno}: from {node.module}")
        elif isinstance(node, ast.Import) and {"cmath", "numpy", "scipy"} & {name.name for name in node.names}:
            found.append(f"line {node.lineno}: import {node.names[0].name}")
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not _is_exact(node, integers):
            found.append(f"line {node.lineno}: {ast.unparse(node)}")
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "pow":
            found.append(f"line {node.lineno}: pow")
    return found


def _is_exact(power: ast.BinOp, integers: frozenset[str]) -> bool:
    """Whether a power is of integers or fractions, or of a power of two that stands there."""
    base, exponent = power.left, power.right
    if isinstance(base, ast.Call) and isinstance(base.func, ast.Name):
        return base.func.id == "Fraction"
    if isinstance(base, ast.Attribute):
        names = {part.attr for part in (base, exponent) if isinstance(part, ast.Attribute)}
        return names <= integers and isinstance(exponent, ast.Constant | ast.Attribute)
    return isinstance(base, ast.Constant) and (isinstance(base.value, int) or base.value == 2.0)


def integers_of(module: ModuleType) -> frozenset[str]:
    """Integer parameters of the blocks in a module."""
    kinds: list[Any] = [kind for kind in all_blocks().values() if kind.__module__ == module.__name__]
    return frozenset(name for kind in kinds for name, p in kind.parameters.items() if p.kind is int)


@pytest.mark.parametrize("name", list(modules()))
def test_blocks_do_not_call_the_c_library(name: str) -> None:
    module = import_module(name)
    assert calls(inspect.getsource(module), integers_of(module)) == []


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("math.sin(x)", ["line 1: math.sin"]),
        ("from math import exp", ["line 1: from math"]),
        ("import numpy", ["line 1: import numpy"]),
        ("x**0.5", ["line 1: x ** 0.5"]),
        ("p.gain**2", ["line 1: p.gain ** 2"]),
        ("pow(x, y)", ["line 1: pow"]),
        ("math.sqrt(x) + math.pi * 2.0**-40 + p.order**2", []),
    ],
)
def test_what_is_refused(source: str, expected: list[str]) -> None:
    assert calls(source, frozenset({"order"})) == expected
