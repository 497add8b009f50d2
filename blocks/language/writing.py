"""Expressions, typed and written anew so that they mean in every engine what Python means.

In plain Python an operation that fails raises. In compiled code its operands are put into variables, whether it fails
is noted in one more, and it goes on; so what Python evaluates only under a condition stands under an `if`.
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
    """Writes expressions; what has to come before one is put behind the statements of `self.lines`."""

    def __init__(self, scope: Scope, compiled: bool) -> None:
        self.scope, self.compiled = scope, compiled
        self.lines: list[ast.stmt] = []
        self.fails = False  # whether anything may

    # -- what is written -------------------------------------------------------------------------------------------

    def kept(self, value: ast.expr) -> ast.expr:
        """A variable that holds the value, in compiled code."""
        if not self.compiled or isinstance(value, ast.Constant):
            return value
        name = self.scope.fresh()
        self.lines.append(assign(name, value))
        return ast.Name(name, ast.Load())

    def bound(self, value: Any) -> ast.expr:
        """The name of a value that is made known to the function."""
        return ast.Name(self.scope.bind(value), ast.Load())

    def applied(self, function: Callable[..., Any], *arguments: ast.expr) -> ast.expr:
        """A call of a function of ours or of Python's."""
        return ast.Call(self.bound(function), list(arguments), [])

    def checked(self, operation: Checked, *operands: ast.expr) -> ast.expr:
        """An operation that may fail."""
        if not self.compiled:
            return self.applied(operation.reference, *operands)
        given = [self.kept(operand) for operand in operands]
        self.note(self.applied(operation.fails, *given))
        return self.applied(operation.value, *given)

    def defined(self, operation: Checked, *operands: ast.expr) -> ast.expr:
        """A function of numbers that has a value only somewhere."""
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
        """What is made, and the statements that have to come before it."""
        before, self.lines = self.lines, []
        try:
            made = make()
        finally:
            lines, self.lines = self.lines, before
        return lines, made

    def expression(self, node: ast.expr) -> Typed:
        """An expression and its type; raises `RefusedError`."""
        raise NotImplementedError

    # -- types -----------------------------------------------------------------------------------------------------

    def number(self, node: ast.expr) -> Typed:
        """An expression that is a number, an integer or a truth value."""
        made, kind = self.expression(node)
        if kind not in NUMBERS:
            raise refuse(node, f"{described(kind)}, where a number is needed", known=kind)
        return made, kind

    def as_number(self, expression: ast.expr, kind: Type) -> ast.expr:
        """A number of an integer, rounded as Python does."""
        if kind is float:
            return expression
        if isinstance(expression, ast.Constant):
            return ast.Constant(float(expression.value))  # type: ignore[arg-type]
        return self.applied(float, expression)

    def as_integer(self, expression: ast.expr, kind: Type) -> ast.expr:
        """An integer of a truth value."""
        if kind is not bool:
            return expression
        if isinstance(expression, ast.Constant):
            return ast.Constant(int(expression.value))  # type: ignore[arg-type]
        return self.applied(int, expression)

    def converted(self, node: ast.AST, expression: ast.expr, kind: Type, wanted: Type, what: str) -> ast.expr:
        """A value as it is declared; nothing is rounded or looked at for truth in silence."""
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
        """Values of which one is taken: all of one type, integers that are written out as numbers where others are."""
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
    """A statement that gives a variable its value."""
    return ast.Assign([ast.Name(name, ast.Store())], value)
