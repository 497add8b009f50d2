"""Expressions apart from calls, typed and rewritten so that they mean in every engine what they mean in Python."""

import ast
import types
from collections.abc import Callable, Sequence
from typing import Any

from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.blocks.language import arithmetic, operations, whole
from proofmass.blocks.language.operations import Checked
from proofmass.blocks.language.refusals import RefusedError, refuse
from proofmass.blocks.language.scope import Scope
from proofmass.blocks.language.values import (
    NUMBERS,
    ListOf,
    Meta,
    Record,
    RefusedType,
    TupleOf,
    Type,
    Vector,
    described,
    entry_of,
    is_record,
)

Typed = tuple[ast.expr, Type]


class Expressions:
    """Reads expressions; an operation that may fail becomes a call of its `Checked`, which raises in plain Python."""

    def __init__(self, scope: Scope) -> None:
        self.scope = scope

    def bound(self, value: Any) -> ast.expr:
        """Make a value known to the function and return its name."""
        return ast.Name(self.scope.bind(value), ast.Load())

    def applied(self, function: Callable[..., Any] | Checked, *arguments: ast.expr) -> ast.expr:
        """Write a call of a function of this package or of Python, or of a fallible operation."""
        return ast.Call(self.bound(function), list(arguments), [])

    def expression(self, node: ast.expr) -> Typed:
        """Rewrite an expression and return it with its type; raises `RefusedError`."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise refuse(node, *_not_compiled(node))
        made, kind = method(node)
        return ast.copy_location(made, node), kind

    def test(self, node: ast.expr) -> ast.expr:
        """Rewrite a condition."""
        if isinstance(node, ast.BoolOp):
            return ast.copy_location(self._joined(node, lambda part: (self.test(part), bool))[0], node)
        made, kind = self.number(node)
        return made if kind is bool else ast.copy_location(ast.Compare(made, [ast.NotEq()], [ast.Constant(0)]), node)

    # -- types -------------------------------------------------------------------------------------

    def number(self, node: ast.expr) -> Typed:
        """Rewrite an expression that must be a number, an integer or a truth value."""
        made, kind = self.expression(node)
        if kind not in NUMBERS:
            raise refuse(node, f"{described(kind)}, where a number is needed", known=kind)
        return made, kind

    def as_number(self, expression: ast.expr, kind: Type) -> ast.expr:
        """Convert an integer to a number, rounded as in Python."""
        return expression if kind is float else self._as(float, expression)

    def as_integer(self, expression: ast.expr, kind: Type) -> ast.expr:
        """Convert a truth value to an integer."""
        return self._as(int, expression) if kind is bool else expression

    def _as(self, kind: type[int] | type[float], expression: ast.expr) -> ast.expr:
        if isinstance(expression, ast.Constant):
            return ast.Constant(kind(expression.value))  # type: ignore[arg-type]
        return self.applied(kind, expression)

    def converted(self, node: ast.AST, expression: ast.expr, kind: Type, wanted: Type, what: str) -> ast.expr:
        """Convert a value to its declared type; never round or test for truth in silence."""
        if kind == wanted or isinstance(wanted, RefusedType) or isinstance(kind, RefusedType):
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
        """Convert alternatives to one type; literal integers become numbers if others are."""
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
            if isinstance(kind, RefusedType):
                raise refuse(node, "", known=kind)
            if kind != first:
                hint = "write float(...) round the integer" if {first, kind} == {int, float} else ""
                raise refuse(node, f"{what} {described(first)} in one case and {described(kind)} in another", hint)
        return [expression for expression, _ in values], first

    # -- expressions -------------------------------------------------------------------------------

    def _constant(self, node: ast.Constant) -> Typed:
        return self.literal(node, node.value)

    def literal(self, node: ast.AST, value: Any) -> Typed:
        """Write a known value: a number, or a tuple of numbers."""
        if isinstance(value, bool):
            return ast.Constant(value), bool
        if isinstance(value, int):
            if not arithmetic.LOWEST <= value <= arithmetic.HIGHEST:
                raise refuse(node, "an integer of more than 64 bits", "write it as a number, such as 1e30")
            return ast.Constant(int(value)), int
        if isinstance(value, float):
            return ast.Constant(float(value)), float
        if is_record(type(value)):
            kind = Record(type(value))
            if all(of in NUMBERS for of in kind.fields.values()):
                return self.bound(value), kind
        elif isinstance(value, tuple) and value:
            kinds = tuple(self.literal(node, entry)[1] for entry in value)
            return self.bound(value), TupleOf(kinds)
        if isinstance(
            value, types.FunctionType | types.BuiltinFunctionType | types.MethodType | types.ModuleType | type
        ):
            return ast.Constant(None), Meta(value)
        if type(value).__module__.partition(".")[0] == "numpy":
            raise refuse(node, f"{ast.unparse(node)} is not compiled", operations.instead_of_numpy(value))
        word = "a text" if isinstance(value, str) else f"a {type(value).__name__}"
        hint = "a table is a tuple of numbers" if hasattr(value, "__len__") and not isinstance(value, str) else ""
        raise refuse(node, f"{word} cannot stand in a block's function", hint or "write numbers")

    def _name(self, node: ast.Name) -> Typed:
        kind = self.scope.local(node)
        if kind is not None:
            if isinstance(kind, RefusedType):
                raise refuse(node, "", known=kind)
            return ast.Name(node.id, ast.Load()), kind
        return self.literal(node, self.scope.outside(node))

    def _attribute(self, node: ast.Attribute) -> Typed:
        owner, kind = self.expression(node.value)
        if isinstance(kind, Meta):
            return self.literal(node, self.scope.member(node, kind.value))
        if isinstance(kind, Record):
            fields = kind.fields
            if node.attr not in fields:
                hint = did_you_mean(node.attr, fields, "its fields")
                raise refuse(node, f"{kind.kind.__name__} has no field {node.attr}", hint)
            if isinstance(fields[node.attr], RefusedType):
                raise refuse(
                    node, f"the field {node.attr} has no type that can be compiled", "declare it float, int or bool"
                )
            return ast.Attribute(owner, node.attr, ast.Load()), fields[node.attr]
        raise refuse(node, f"{described(kind)} has no {node.attr}", _METHODS.get(node.attr, ""), known=kind)

    def _tuple(self, node: ast.Tuple) -> Typed:
        parts = [self.expression(part) for part in node.elts]
        for part, (_, kind) in zip(node.elts, parts, strict=True):
            if isinstance(kind, Meta):
                raise refuse(part, f"{described(kind)} cannot be an entry")
        return ast.Tuple([made for made, _ in parts], ast.Load()), TupleOf(tuple(kind for _, kind in parts))

    def _unaryop(self, node: ast.UnaryOp) -> Typed:
        if isinstance(node.op, ast.Not):
            return ast.UnaryOp(node.op, self.test(node.operand)), bool
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant):
            value = node.operand.value
            if isinstance(value, int | float):
                return self.literal(node, -value)
        operand, kind = self.number(node.operand)
        if kind is float and isinstance(node.op, ast.Invert):
            raise refuse(node, "~ of a number", "~ is of integers")
        if kind is bool:
            operand, kind = self.as_integer(operand, kind), int
        if isinstance(node.op, ast.UAdd):
            return operand, kind
        negative = kind is int and isinstance(node.op, ast.USub)
        return self.applied(operations.NEGATE, operand) if negative else ast.UnaryOp(node.op, operand), kind

    def _binop(self, node: ast.BinOp) -> Typed:
        left = self.number(node.left)
        return self.operated(node, type(node.op), left, self.number(node.right))

    def operated(self, node: ast.AST, operator: type[ast.operator], left: Typed, right: Typed) -> Typed:
        """Apply an operator to two numbers."""
        (a, first), (b, second) = left, right
        known = b.value if isinstance(b, ast.Constant) else None
        number = float in (first, second)
        if operator is ast.Pow and (number or (isinstance(known, int) and known < 0)):
            return self.applied(operations.POWER, self.as_number(*left), self.as_number(*right)), float
        if number and (operator in operations.PLAIN or (operator is ast.Div and known)):
            return ast.BinOp(a, operator(), b), float
        if not number and (operator in operations.BITWISE or _surely_succeeds(operator, known)):
            both = bool if operator in operations.BITWISE and first is second is bool else int
            return ast.BinOp(a, operator(), b), both
        operation = (operations.OF_NUMBERS if number else operations.OF_INTEGERS).get(operator)
        if operation:
            convert = self.as_number if number else self.as_integer
            return self.applied(operation, convert(*left), convert(*right)), operation.result
        if operator is ast.MatMult:
            raise refuse(node, "@ is of matrices", "write loops over the entries")
        raise refuse(node, "bits of a number", "the operators of bits are of integers: write int(...)")

    def _boolop(self, node: ast.BoolOp) -> Typed:
        return self._joined(node, self.number)

    def _joined(self, node: ast.BoolOp, read: Callable[[ast.expr], Typed]) -> Typed:
        values, kind = self.agreed(node, [read(part) for part in node.values], "the value is")
        return ast.BoolOp(node.op, values), kind

    def _ifexp(self, node: ast.IfExp) -> Typed:
        test, parts = self.test(node.test), [self.expression(node.body), self.expression(node.orelse)]
        (a, b), kind = self.agreed(node, parts, "the value is")
        return ast.IfExp(test, a, b), kind

    def _compare(self, node: ast.Compare) -> Typed:
        for operator in node.ops:
            if isinstance(operator, ast.Is | ast.IsNot):
                raise refuse(node, "is is not compiled", "compare with ==")
            if isinstance(operator, ast.In | ast.NotIn):
                return self._among(node), bool
        left, *others = [self.number(part)[0] for part in (node.left, *node.comparators)]
        return ast.Compare(left, node.ops, others), bool

    def _among(self, node: ast.Compare) -> ast.expr:
        """Rewrite `in`: whether a number is an entry of a tuple."""
        if len(node.ops) > 1:
            raise refuse(node, "in within a chain of comparisons", "join them by `and`")
        left, _ = self.number(node.left)
        entries, kind = self.expression(node.comparators[0])
        if not isinstance(kind, TupleOf) or not all(entry in NUMBERS for entry in kind.entries):
            raise refuse(node, f"in, of {described(kind)}", "write a loop over its entries", known=kind)
        among = self.applied(whole.is_among, left, entries)
        return among if isinstance(node.ops[0], ast.In) else ast.UnaryOp(ast.Not(), among)

    def _subscript(self, node: ast.Subscript) -> Typed:
        sequence, kind = self.expression(node.value)
        if isinstance(node.slice, ast.Slice):
            raise refuse(node, "a part of a list", "write a loop over its entries")
        if isinstance(kind, TupleOf) and isinstance(node.slice, ast.Constant | ast.UnaryOp):
            index = _known(node.slice)
            if isinstance(index, int):
                if not -len(kind.entries) <= index < len(kind.entries):
                    raise refuse(node, f"there is no entry {index} in {described(kind)}")
                entry = kind.entries[index]
                return ast.Subscript(sequence, ast.Constant(index % len(kind.entries)), ast.Load()), entry
        return ast.Subscript(sequence, self.index(node, sequence, kind), ast.Load()), self._entry(node, kind)

    def index(self, node: ast.Subscript, sequence: ast.expr, kind: Type) -> ast.expr:
        """Write the place of an entry, checked to exist."""
        self._entry(node, kind)
        place, of = self.number(node.slice)
        if of is float:
            raise refuse(node.slice, "an index is an integer, and is given a number", "write int(...)")
        return self.applied(operations.PLACE, self.as_integer(place, of), self.applied(len, sequence))

    def _entry(self, node: ast.AST, kind: Type) -> Type:
        entry = entry_of(kind)
        if entry is None:
            message = f"{described(kind)} has no entries that an index may choose"
            hint = "make all its entries of one type" if isinstance(kind, TupleOf) else ""
            raise refuse(node, message, hint, known=kind)
        return entry

    def sequence(self, node: ast.expr) -> tuple[ast.expr, Type]:
        """Rewrite the sequence of a loop and return it with the type of its entries."""
        sequence, kind = self.expression(node)
        if not isinstance(kind, TupleOf | ListOf | Vector):
            raise refuse(
                node, f"a loop over {described(kind)}", "loops go over range(...), tuples and buffers", known=kind
            )
        return sequence, self._entry(node, kind)


def assign(name: str, value: ast.expr) -> ast.stmt:
    """Write the assignment of a variable."""
    return ast.Assign([ast.Name(name, ast.Store())], value)


def _surely_succeeds(operator: type[ast.operator], second: Any) -> bool:
    """Return whether an operation of integers never fails since its second operand is a literal."""
    if not isinstance(second, int):
        return False
    return (operator is ast.RShift and 0 <= second <= 63) or (
        operator in (ast.FloorDiv, ast.Mod) and second not in (0, -1)
    )


def _known(node: ast.expr) -> Any:
    try:
        return ast.literal_eval(node)
    except ValueError:
        return None


def _not_compiled(node: ast.AST) -> tuple[str, str]:
    """Return why an expression is refused, and what to write instead."""
    what, hint = RefusedError.CONSTRUCTS.get(type(node).__name__, (type(node).__name__, "write it with numbers"))
    return f"{what} is not compiled", hint


_METHODS = {"append": "declare a Buffer, and write buffer[place] = value", "sum": "add the entries up in a loop"}
