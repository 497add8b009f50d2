"""Expressions, typed and rewritten so that they mean in every engine what they mean in Python.

In plain Python an operation that fails raises. Compiled code puts its operands into variables, notes a failure in
another one, and goes on; so whatever Python evaluates only under a condition stands under an `if`.
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
    """Writes expressions; statements that must come before one are appended to `self.lines`."""

    def __init__(self, scope: Scope, compiled: bool) -> None:
        self.scope, self.compiled = scope, compiled
        self.lines: list[ast.stmt] = []
        self.fails = False  # whether anything may

    # -- what is written -------------------------------------------------------------------------------------------

    def kept(self, value: ast.expr) -> ast.expr:
        """Store a value in a variable, in compiled code, and return the variable."""
        if not self.compiled or isinstance(value, ast.Constant):
            return value
        name = self.scope.fresh()
        self.lines.append(assign(name, value))
        return ast.Name(name, ast.Load())

    def bound(self, value: Any) -> ast.expr:
        """Make a value known to the function and return its name."""
        return ast.Name(self.scope.bind(value), ast.Load())

    def applied(self, function: Callable[..., Any], *arguments: ast.expr) -> ast.expr:
        """Write a call of a function of this package or of Python."""
        return ast.Call(self.bound(function), list(arguments), [])

    def checked(self, operation: Checked, *operands: ast.expr) -> ast.expr:
        """Write an operation that may fail."""
        if not self.compiled:
            return self.applied(operation.reference, *operands)
        given = [self.kept(operand) for operand in operands]
        self.note(self.applied(operation.fails, *given))
        return self.applied(operation.value, *given)

    def defined(self, operation: Checked, *operands: ast.expr) -> ast.expr:
        """Write a function of numbers that may have no value."""
        if not self.compiled:
            return self.applied(operation.reference, *operands)
        given = [self.kept(operand) for operand in operands]
        value = self.kept(self.applied(operation.value, *given))
        self.note(self.applied(operation.fails, value, *given))
        return value

    def note(self, failed: ast.expr) -> None:
        """Note a fault."""
        self.fails = True
        fault = ast.Name(self.scope.fault, ast.Load())
        self.lines.append(assign(self.scope.fault, ast.BinOp(fault, ast.BitOr(), failed)))

    def apart(self, make: Callable[[], Any]) -> tuple[list[ast.stmt], Any]:
        """Call `make`; return the statements that must come before its result, and the result."""
        before, self.lines = self.lines, []
        try:
            made = make()
        finally:
            lines, self.lines = self.lines, before
        return lines, made

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
