"""Calls in a function: of functions of Python and `math`, of named tuples, and a user's."""

import ast
import inspect
import math
import types
from typing import Any

from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.blocks.language import operations, whole
from proofmass.blocks.language.expressions import Expressions, Typed
from proofmass.blocks.language.refusals import refuse
from proofmass.blocks.language.values import NUMBERS, Meta, Record, TupleOf, Type, described, is_record


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
            return self._made(node, Record(target), dict(zip(target._fields, self.given(node, target), strict=True)))
        if target is math.isclose:
            read = [self.converted(node, *part, float, "an argument of isclose") for part in self.given(node, target)]
            return self.applied(operations.IS_CLOSE, *read), bool
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

    def given(self, node: ast.Call, target: Any) -> list[Typed]:
        """Rewrite arguments of a call in the order of the parameters, with defaults filled in."""
        if any(isinstance(part, ast.Starred) for part in node.args) or any(k.arg is None for k in node.keywords):
            raise refuse(node, "* in a call", "write the arguments one by one")
        signature = inspect.signature(target)
        try:
            bound = signature.bind(*node.args, **{str(keyword.arg): keyword.value for keyword in node.keywords})
        except TypeError as error:
            raise refuse(
                node, f"{target.__name__}: {error}", f"its arguments: {', '.join(signature.parameters)}"
            ) from None
        arguments = []
        for name, parameter in signature.parameters.items():
            if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
                raise refuse(node, f"{target.__name__} has * among its arguments", "name them one by one")
            value = bound.arguments.get(name)
            arguments.append(self.expression(value) if value is not None else self.literal(node, parameter.default))
        return arguments

    def _made(self, node: ast.AST, kind: Record, values: dict[str, Typed]) -> Typed:
        fields = kind.fields
        made = [self.converted(node, *values[n], of, f"the field {n}") for n, of in fields.items()]
        return ast.Call(self.bound(kind.kind), made, []), kind

    def _known_function(self, node: ast.Call, target: Any) -> Typed | None:
        """Write a call of a function of Python or `math`; None for one that is not compiled."""
        count = len(node.args)
        if target is len and count == 1:
            return self.applied(len, self.sequence(node.args[0])[0]), int
        if target is float and _names_no_number(node):
            return ast.Constant(float(ast.literal_eval(node.args[0]))), float
        if any(isinstance(part, ast.Starred) for part in node.args):
            return None
        if target in (*operations.EXTREMES, *operations.TOTALS) and count == 1:
            return self._reduced(node, target)
        if target in (min, max) and count:
            values, kind = self.agreed(node, list(map(self.number, node.args)), f"{target.__name__}() is of")
            return self.applied(target, *values), kind
        if (target, count) in ((pow, 2), (divmod, 2), (math.log, 2)):
            return self._of_two(node, target, *map(self.number, node.args))
        called, kinds, result = operations.FUNCTIONS.get(target, operations.NO_FUNCTION)
        if called is not None and count == len(kinds):
            what = f"an argument of {target.__name__}"
            read = [
                self.converted(node, *self.number(part), of, what) for part, of in zip(node.args, kinds, strict=True)
            ]
            return self.applied(called, *read), result
        if count == 1 and (target in operations.TO_INTEGER or target in (float, bool, abs)):
            return self._of_one(target, *self.number(node.args[0]))
        return None

    def _of_two(self, node: ast.Call, target: Any, a: Typed, b: Typed) -> Typed:
        """Write what is an operation of two numbers: a power, a quotient with its remainder, a logarithm to a base."""
        if target is pow:
            return self.operated(node, ast.Pow, a, b)
        if target is divmod:
            (quotient, first), (left, second) = (self.operated(node, sign, a, b) for sign in (ast.FloorDiv, ast.Mod))
            return ast.Tuple([quotient, left], ast.Load()), TupleOf((first, second))
        x, base = (self.applied(operations.FUNCTIONS[math.log][0], self.as_number(*part)) for part in (a, b))
        return self.operated(node, ast.Div, (x, float), (base, float))

    def _of_one(self, target: Any, expression: ast.expr, kind: Type) -> Typed:
        """Write a conversion or an absolute value, which follow the type of the number."""
        if target is float:
            return self.as_number(expression, kind), float
        if target is bool:
            return (expression if kind is bool else ast.Compare(expression, [ast.NotEq()], [ast.Constant(0)])), bool
        if target is abs and kind is float:
            return self.applied(abs, expression), float
        if kind is float:
            return self.applied(operations.TO_INTEGER[target], expression), int
        expression = self.as_integer(expression, kind)
        return (self.applied(operations.ABSOLUTE, expression) if target is abs else expression), int

    def _reduced(self, node: ast.Call, target: Any) -> Typed:
        """Write min, max, sum or math.prod of the entries of the one argument."""
        entries, kind = self.sequence(node.args[0])
        if kind not in NUMBERS:
            raise refuse(node, f"{target.__name__}() of {described(kind)}", "its entries must be numbers")
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
    module, owner = operations.modules_of(target)
    shown = ast.unparse(node.func)
    for place in (module, owner, shown.partition(".")[0]):
        if place in operations.UNREPEATABLE:
            return f"{shown}() would make a run another each time", operations.UNREPEATABLE[place]
        if place in operations.OUTSIDE:
            return f"{shown}() reaches outside the block", "a block sees its parameters, state and inputs only"
    instead = operations.INSTEAD.get(target)
    if module == "numpy":
        instead = operations.instead_of_numpy(target)
    if target is round:
        instead = "round(x) is the nearest integer: scale before and after it"
    return f"{shown}() is not compiled", instead or f"write {name} as a function of your own, of numbers"
