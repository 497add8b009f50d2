"""Refusals of parts of a function: where, why, and what to write instead."""

import ast
import types
from typing import ClassVar

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.language.values import RefusedType, Type


class RefusedError(Exception):
    """Something cannot be compiled; without a message if it was reported before."""

    CONSTRUCTS: ClassVar[dict[str, tuple[str, str]]] = {
        "ListComp": ("a comprehension", "write a loop, into a buffer or a sum"),
        "GeneratorExp": ("a comprehension", "write a loop, into a buffer or a sum"),
        "SetComp": ("a comprehension", "write a loop"),
        "DictComp": ("a comprehension", "write a loop"),
        "List": ("a list", "declare a Buffer for values that change, or write a tuple for constants"),
        "Set": ("a set", "write a tuple"),
        "Dict": ("a dict", "write a tuple and an integer index"),
        "Lambda": ("a lambda", "define a function at the top of the file"),
        "NamedExpr": ("an assignment within an expression", "give it a line of its own"),
        "JoinedStr": ("a text", "functions of a block work with numbers"),
        "Starred": ("* in a call", "write the arguments one by one"),
        "Yield": ("yield", "a block's function computes and returns"),
        "YieldFrom": ("yield", "a block's function computes and returns"),
        "Try": ("try", "look at the numbers before the operation: if divisor != 0.0"),
        "TryStar": ("try", "look at the numbers before the operation"),
        "With": ("with", "a block's function computes and returns; read files in `constants`"),
        "FunctionDef": ("a function within a function", "define it at the top of the file"),
        "AsyncFunctionDef": ("async", "a block's function computes and returns"),
        "ClassDef": ("a class within a function", "define it at the top of the file"),
        "Import": ("an import within a function", "import at the top of the file"),
        "ImportFrom": ("an import within a function", "import at the top of the file"),
        "Global": ("global", "what a block remembers is its state: return it from update"),
        "Nonlocal": ("nonlocal", "what a block remembers is its state: return it from update"),
        "Delete": ("del", "leave the variable be"),
        "Match": ("match", "write if and elif"),
    }

    def __init__(self, node: ast.AST, message: str, hint: str) -> None:
        super().__init__(message)
        self.node, self.message, self.hint = node, message, hint


def refuse(node: ast.AST, message: str, hint: str = "", known: Type | None = None) -> RefusedError:
    """Return the refusal of something; a silent one if its cause was refused already."""
    return RefusedError(node, "" if isinstance(known, RefusedType) else message, hint)


def problem_at(function: types.FunctionType, node: ast.AST | None, message: str, hint: str) -> Problem:
    """Return the problem at a node of a function, of whose text the first line is shown."""
    shown = "" if node is None else f"def {node.name}" if isinstance(node, ast.FunctionDef) else ast.unparse(node)
    shown = shown.partition("\n")[0]
    return Problem(
        message=message,
        file=function.__code__.co_filename,
        line=getattr(node, "lineno", function.__code__.co_firstlineno),
        key=function.__name__,
        got=shown if len(shown) <= 80 else f"{shown[:77]}...",
        hint=hint,
    )
