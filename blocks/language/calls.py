"""Calls in a function: of functions of Python and `math`, of named tuples, and of a user's functions."""

import ast
import math
import types
from collections.abc import Iterable, Sequence
from typing import Any

from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.blocks.language import operations, whole
from proofmass.blocks.language.expressions import Expressions
from proofmass.blocks.language.operations import Checked
from proofmass.blocks.language.refusals import refuse
from proofmass.blocks.language.values import NUMBERS, Meta, Record, TupleOf, Type, described, is_record
from proofmass.blocks.language.writing import Typed


class Calls(Expressions):
    """Reads calls."""

    def call(self, node: ast.Call, target: types.FunctionType) -> Typed:
        """A call of a user's function."""
        raise NotImplementedError

    def _call(self, node: ast.Call) -> Typed:
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._replaced(node, node.func)
        _, kind = self.expression(node.func)
        if not isinstance(kind, Meta):
            raise refuse(node, f"{described(kind)} cannot be called", known=kind)
        target = kind.value
        if isinstance(target, types.FunctionType):
            return self.call(node, target)
        if is_record(target):
            return self._record(node, target)
        if target is math.isclose:
            return self._close(node)
        made = self._known_function(node, target) if not node.keywords else None
        if made is not None:
            return made
        raise refuse(node, *_no_function(node, target))

    def _replaced(self, node: ast.Call, function: ast.Attribute) -> Typed:
        record, kind = self.expression(function.value)
        if not isinstance(kind, Record):
            raise refuse(node, f"{described(kind)} has no _replace", known=kind)
        new = {keyword.arg: keyword.value for keyword in node.keywords}
        for name in new:
            if name not in kind.fields:
                hint = did_you_mean(str(name), kind.fields, "its fields")
                raise refuse(node, f"{kind.kind.__name__} has no field {name}", hint)
        replaced = {name: self.expression(value) for name, value in new.items()}
        rest = {name: (ast.Attribute(record, name, ast.Load()), of) for name, of in kind.fields.items()}
        return self._made(node, kind, rest | replaced)  # type: ignore[operator]

    def _record(self, node: ast.Call, kind: Any) -> Typed:
        names, defaults = list(kind._fields), kind._field_defaults
        if any(isinstance(part, ast.Starred) for part in node.args) or any(k.arg is None for k in node.keywords):
            raise refuse(node, "* in a call", f"write the fields: {', '.join(names)}")
        arguments = dict(zip(names, node.args, strict=False)) | {str(k.arg): k.value for k in node.keywords}
        missing = [name for name in names if name not in arguments and name not in defaults]
        if missing or len(node.args) > len(names) or not set(arguments) <= set(names):
            raise refuse(node, f"{kind.__name__} is given other fields than it has", f"its fields: {', '.join(names)}")
        read = {name: self.expression(value) for name, value in arguments.items()}
        read |= {name: self.literal(node, defaults[name]) for name in names if name not in arguments}
        return self._made(node, Record(kind), read)

    def _made(self, node: ast.AST, kind: Record, values: dict[str, Typed]) -> Typed:
        fields = kind.fields
        made = [self.converted(node, *values[n], of, f"the field {n}") for n, of in fields.items()]
        return ast.Call(self.bound(kind.kind), made, []), kind

    def _known_function(self, node: ast.Call, target: Any) -> Typed | None:
        if target is len and len(node.args) == 1:
            expression, _ = self.sequence(node.args[0])
            return self.applied(len, expression), int
        if target is float and _names_no_number(node):
            return ast.Constant(float(ast.literal_eval(node.args[0]))), float
        if target not in _OF_NUMBERS or any(isinstance(part, ast.Starred) for part in node.args):
            return None
        if target in (*operations.EXTREMES, *operations.TOTALS) and len(node.args) == 1:
            return self._reduced(node, target)
        arguments = [self.number(part) for part in node.args]
        if target in (min, max):
            return self._extreme(node, target, arguments)
        if target in (pow, math.pow) and len(arguments) == 2:
            if target is math.pow:
                return self.applied(operations.TWO[math.pow], *self._numbers(arguments)), float
            return self.operated(node, ast.Pow, *arguments)
        if target is divmod and len(arguments) == 2:
            parts = [self.operated(node, sign, *arguments) for sign in (ast.FloorDiv, ast.Mod)]
            return ast.Tuple([expression for expression, _ in parts], ast.Load()), TupleOf(
                tuple(kind for _, kind in parts)
            )
        if target is math.log and len(arguments) == 2:
            parts = [(self.applied(operations.ONE[math.log], self.as_number(*part)), float) for part in arguments]
            return self.operated(node, ast.Div, *parts)
        if target is math.ldexp and len(arguments) == 2:
            if arguments[1][1] is float:
                raise refuse(node, "math.ldexp with a number as exponent", "write int(...)")
            parts_of = self.as_number(*arguments[0]), self.as_integer(*arguments[1])
            return self.applied(operations.LOAD_EXPONENT, *parts_of), float
        if target in operations.TWO and len(arguments) == 2:
            return self._of_numbers(target, operations.TWO[target], arguments), float
        if target in operations.OF_WHOLE and len(arguments) == operations.OF_WHOLE[target][0]:
            if any(kind is float for _, kind in arguments):
                raise refuse(node, f"{target.__name__} of a number", "it is of integers")
            return self.applied(operations.OF_WHOLE[target][1], *(self.as_integer(*part) for part in arguments)), int
        return self._of_one(node, target, *arguments[0]) if len(arguments) == 1 else None

    def _of_one(self, node: ast.Call, target: Any, expression: ast.expr, kind: Type) -> Typed | None:
        if target in operations.ONE:
            return self._of_numbers(target, operations.ONE[target], [(expression, kind)]), float
        if target in operations.LOOKS:
            return self.applied(target, self.as_number(expression, kind)), bool
        if target in operations.SCALED:
            return ast.BinOp(
                self.as_number(expression, kind), ast.Mult(), ast.Constant(operations.SCALED[target])
            ), float
        if target is math.fabs:
            return self.applied(abs, self.as_number(expression, kind)), float
        if target is float:
            return self.as_number(expression, kind), float
        if target is bool:
            return (expression if kind is bool else ast.Compare(expression, [ast.NotEq()], [ast.Constant(0)])), bool
        whole: dict[Any, Checked] = {int: operations.TRUNCATE, round: operations.NEAREST, **operations.ROUND}
        if target in whole:
            return (
                self.applied(whole[target], expression) if kind is float else self.as_integer(expression, kind)
            ), int
        if target is abs:
            if kind is float:
                return self.applied(abs, expression), float
            return self.applied(operations.ABSOLUTE, self.as_integer(expression, kind)), int
        return None

    def _close(self, node: ast.Call) -> Typed:
        """Write `math.isclose`; the tolerances may be keyword arguments."""
        named = {str(keyword.arg): keyword.value for keyword in node.keywords}
        if len(node.args) != 2 or not set(named) <= set(operations.TOLERANCES):
            raise refuse(node, "math.isclose is of two numbers", "write math.isclose(a, b, rel_tol=..., abs_tol=...)")
        read = [self.number(part) for part in node.args]
        read += [
            self.number(named[name]) if name in named else (ast.Constant(default), float)
            for name, default in operations.TOLERANCES.items()
        ]
        return self.applied(operations.IS_CLOSE, *self._numbers(read)), bool

    def _numbers(self, given: Iterable[Typed]) -> list[ast.expr]:
        return [self.as_number(made, kind) for made, kind in given]

    def _of_numbers(self, target: Any, operation: Checked, given: Sequence[Typed]) -> ast.expr:
        if target in operations.NEVER_FAIL:
            return self.applied(target, *self._numbers(given))
        return self.applied(operation, *self._numbers(given))

    def _extreme(self, node: ast.Call, target: Any, given: Sequence[Typed]) -> Typed:
        values, kind = self.agreed(node, given, f"{target.__name__}() is of")
        return self.applied(target, *values), kind

    def _reduced(self, node: ast.Call, target: Any) -> Typed:
        """Write min, max, sum or math.prod of the entries of the one argument."""
        entries, kind = self.sequence(node.args[0])
        if kind not in NUMBERS:
            raise refuse(node, f"{target.__name__}() of what is {described(kind)}", "its entries must be numbers")
        if target in operations.EXTREMES:
            return self.applied(operations.EXTREMES[target], entries), kind
        if target is sum and kind is float:
            raise refuse(node, "sum() of numbers is not compiled", operations.INSTEAD[sum])
        if kind is float:
            return self.applied(whole.product_of_numbers, entries), kind
        return self.applied(operations.TOTALS[target], entries), int


def _names_no_number(node: ast.Call) -> bool:
    """Return whether a call is float("nan"), or an infinity."""
    text = node.args[0].value if len(node.args) == 1 and isinstance(node.args[0], ast.Constant) else None
    return isinstance(text, str) and text.strip().lower().lstrip("+-") in ("nan", "inf", "infinity")


def _no_function(node: ast.Call, target: Any) -> tuple[str, str]:
    """Return why something cannot be called, and what to write instead."""
    name = getattr(target, "__name__", "it")
    module = str(getattr(target, "__module__", "") or "").partition(".")[0]
    owner = str(getattr(getattr(target, "__self__", None), "__module__", "") or "").partition(".")[0]
    shown = ast.unparse(node.func)
    for place in (module.lstrip("_"), owner, shown.partition(".")[0]):
        if place in operations.UNREPEATABLE:
            return f"{shown}() would make a run another each time", operations.UNREPEATABLE[place]
        if place in operations.OUTSIDE:
            return f"{shown}() reaches outside the block", "a block sees its parameters, state and inputs only"
    try:
        instead = operations.INSTEAD.get(target)
    except TypeError:
        instead = None
    if target is round:
        instead = "round(x) is the nearest integer: scale before and after it"
    return f"{shown}() is not compiled", instead or f"write {name} as a function of your own, of numbers"


_OF_NUMBERS: set[Any] = {
    *operations.ONE,
    *operations.TWO,
    *operations.OF_WHOLE,
    *operations.LOOKS,
    *operations.SCALED,
    *operations.ROUND,
    *(abs, bool, divmod, float, int, max, min, pow, round, sum, math.fabs, math.ldexp, math.prod),
}
