"""Expressions, typed and rewritten so that they mean in every engine what they mean in Python.

An operation that may fail becomes a call of its `Checked`, which raises in plain Python.
"""

import ast
from collections.abc import Callable, Sequence
from typing import Any

from proofmass.blocks.language.operations import Checked
from proofmass.blocks.language.refusals import refuse
from proofmass.blocks.language.scope import Scope
from proofmass.blocks.language.values import NUMBERS, Record, TupleOf, Type, Unknown, described

Typed = tuple[ast.expr, Type]


class Writer:
    """Writes expressions."""

    def __init__(self, scope: Scope) -> None:
        self.scope = scope

    def bound(self, value: Any) -> ast.expr:
        """Make a value known to the function and return its name."""
        return ast.Name(self.scope.bind(value), ast.Load())

    def applied(self, function: Callable[..., Any] | Checked, *arguments: ast.expr) -> ast.expr:
        """Write a call of a function of this package or of Python, or of an operation that may fail."""
        return ast.Call(self.bound(function), list(arguments), [])

    def expression(self, node: ast.expr) -> Typed:
        """Rewrite an expression and return it with its type; raises `RefusedError`."""
        raise NotImplementedError

    # -- types -----------------------------------------------------------------------------------------------------

    def number(self, node: ast.expr) -> Typed:
        """Rewrite an expression that must be a number, an integer or a truth value."""
        made, kind = self.expression(node)
        if kind not in NUMBERS:
            raise refuse(node, f"{described(kind)}, where a number is needed", known=kind)
        return made, kind

    def as_number(self, expression: ast.expr, kind: Type) -> ast.expr:
        """Convert an integer to a number, rounded as in Python."""
        if kind is float:
            return expression
        if isinstance(expression, ast.Constant):
            return ast.Constant(float(expression.value))  # type: ignore[arg-type]
        return self.applied(float, expression)

    def as_integer(self, expression: ast.expr, kind: Type) -> ast.expr:
        """Convert a truth value to an integer."""
        if kind is not bool:
            return expression
        if isinstance(expression, ast.Constant):
            return ast.Constant(int(expression.value))  # type: ignore[arg-type]
        return self.applied(int, expression)

    def converted(self, node: ast.AST, expression: ast.expr, kind: Type, wanted: Type, what: str) -> ast.expr:
        """Convert a value to its declared type; never round or test for truth in silence."""
        if kind == wanted or isinstance(wanted, Unknown) or isinstance(kind, Unknown):
            return expression
        if wanted is float and kind in NUMBERS:
            return self.as_number(expression, kind)
        if wanted is int and kind is bool:
            return self.as_integer(expression, kind)
        hints = {int: "write int(...), round(...) or math.floor(...)", bool: "write a comparison, such as value != 0"}
        hint = hints.get(wanted, "") if kind in NUMBERS else ""  # type: ignore[arg-type]
        if isinstance(wanted, Record) and isinstance(kind, TupleOf):
            hint = f"return {wanted.kind.__name__}(...)"
        raise refuse(node, f"{what} is {described(wanted)}, and is given {described(kind)}", hint)

    def agreed(self, node: ast.AST, values: Sequence[Typed], what: str) -> tuple[list[ast.expr], Type]:
        """Convert alternatives to one type; literal integers become numbers if others are numbers."""
        kinds = [kind for _, kind in values]
        if float in kinds:
            values = [
                (ast.Constant(float(expression.value)), float)  # type: ignore[arg-type]
                if kind is int and isinstance(expression, ast.Constant)
                else (expression, kind)
                for expression, kind in values
            ]
        first = values[0][1]
        for _, kind in values:
            if isinstance(kind, Unknown):
                raise refuse(node, "", known=kind)
            if kind != first:
                hint = "write float(...) round the integer" if {first, kind} == {int, float} else ""
                raise refuse(node, f"{what} {described(first)} in one case and {described(kind)} in another", hint)
        return [expression for expression, _ in values], first


def assign(name: str, value: ast.expr) -> ast.stmt:
    """Write the assignment of a variable."""
    return ast.Assign([ast.Name(name, ast.Store())], value)
