"""Expressions, typed and written anew so that they mean in every engine what Python means.

In plain Python an operation that fails raises. In compiled code its operands are put into variables, whether it fails
is noted in one more, and it goes on; so what Python evaluates only under a condition stands under an `if`.
"""

import ast
import math
import types
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from proofmass.blocks.language import arithmetic, operations
from proofmass.blocks.language.operations import Checked
from proofmass.blocks.language.refusals import RefusedError, refuse
from proofmass.blocks.language.scope import Scope
from proofmass.blocks.language.values import (
    NUMBERS,
    ListOf,
    Meta,
    Record,
    TupleOf,
    Type,
    Unknown,
    Vector,
    described,
    entry_of,
    is_record,
)
from proofmass.blocks.problem import did_you_mean

Typed = tuple[ast.expr, Type]
_ORDER = (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq)
_SURELY_EXACT = 2**53


class Expressions:
    """Reads expressions; what has to come before one is put behind the statements of `self.lines`."""

    def __init__(self, scope: Scope, compiled: bool) -> None:
        self.scope, self.compiled = scope, compiled
        self.lines: list[ast.stmt] = []
        self.fails = False  # whether anything may

    def call(self, node: ast.Call, target: types.FunctionType) -> Typed:
        """A call of a user's function."""
        raise NotImplementedError

    # -- what is written -------------------------------------------------------------------------------------------

    def kept(self, value: ast.expr) -> ast.expr:
        """A variable that holds the value, in compiled code."""
        if not self.compiled or isinstance(value, ast.Constant):
            return value
        name = self.scope.fresh()
        self.lines.append(_assign(name, value))
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
        self.lines.append(_assign(self.scope.fault, ast.BinOp(fault, ast.BitOr(), failed)))

    def apart(self, make: Callable[[], Any]) -> tuple[list[ast.stmt], Any]:
        """What is made, and the statements that have to come before it."""
        before, self.lines = self.lines, []
        try:
            made = make()
        finally:
            lines, self.lines = self.lines, before
        return lines, made

    # -- types -----------------------------------------------------------------------------------------------------

    def number(self, node: ast.expr) -> Typed:
        """An expression that is a number, an integer or a truth value."""
        made, kind = self.expression(node)
        if kind not in NUMBERS:
            raise refuse(node, f"{described(kind)}, where a number is needed", known=kind)
        return made, kind

    def as_number(self, made: ast.expr, kind: Type) -> ast.expr:
        """A number of an integer, rounded as Python does."""
        if kind is float:
            return made
        if isinstance(made, ast.Constant):
            return ast.Constant(float(made.value))  # type: ignore[arg-type]
        return self.applied(float, made)

    def as_integer(self, made: ast.expr, kind: Type) -> ast.expr:
        """An integer of a truth value."""
        if kind is not bool:
            return made
        return ast.Constant(int(made.value)) if isinstance(made, ast.Constant) else self.applied(int, made)  # type: ignore[arg-type]

    def converted(self, node: ast.AST, made: ast.expr, kind: Type, wanted: Type, what: str) -> ast.expr:
        """A value as it is declared; nothing is rounded or looked at for truth in silence."""
        if kind == wanted or isinstance(wanted, Unknown) or isinstance(kind, Unknown):
            return made
        if wanted is float and kind in NUMBERS:
            return self.as_number(made, kind)
        if wanted is int and kind is bool:
            return self.as_integer(made, kind)
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
                (ast.Constant(float(made.value)), float)  # type: ignore[arg-type]
                if kind is int and isinstance(made, ast.Constant)
                else (made, kind)
                for made, kind in values
            ]
        first = values[0][1]
        for _, kind in values:
            if isinstance(kind, Unknown):
                raise refuse(node, "", known=kind)
            if kind != first:
                hint = "write float(...) round the integer" if {first, kind} == {int, float} else ""
                raise refuse(node, f"{what} {described(first)} in one case and {described(kind)} in another", hint)
        return [made for made, _ in values], first

    # -- expressions -----------------------------------------------------------------------------------------------

    def expression(self, node: ast.expr) -> Typed:
        """An expression and its type; raises `RefusedError`."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise refuse(node, *_not_compiled(node))
        made, kind = method(node)
        return ast.copy_location(made, node), kind

    def test(self, node: ast.expr) -> ast.expr:
        """A condition."""
        if isinstance(node, ast.BoolOp):
            return ast.copy_location(self._joined(node, lambda part: (self.test(part), bool))[0], node)
        made, kind = self.number(node)
        return made if kind is bool else ast.copy_location(ast.Compare(made, [ast.NotEq()], [ast.Constant(0)]), node)

    def _constant(self, node: ast.Constant) -> Typed:
        return self.literal(node, node.value)

    def literal(self, node: ast.AST, value: Any) -> Typed:
        """A value that is known: a number, or a tuple of them."""
        if isinstance(value, bool):
            return ast.Constant(value), bool
        if isinstance(value, int):
            if not arithmetic.LOWEST <= value <= arithmetic.HIGHEST:
                raise refuse(node, "an integer of more than 64 bits", "write it as a number, such as 1e30")
            return ast.Constant(int(value)), int
        if isinstance(value, float):
            return ast.Constant(float(value)), float
        if isinstance(value, tuple) and value and not is_record(type(value)):
            kinds = tuple(self.literal(node, entry)[1] for entry in value)
            return self.bound(value), TupleOf(kinds)
        if isinstance(
            value, types.FunctionType | types.BuiltinFunctionType | types.MethodType | types.ModuleType | type
        ):
            return ast.Constant(None), Meta(value)
        word = "a text" if isinstance(value, str) else f"a {type(value).__name__}"
        hint = "a table is a tuple of numbers" if hasattr(value, "__len__") and not isinstance(value, str) else ""
        raise refuse(node, f"{word} is no value of a block's function", hint or "write numbers")

    def _name(self, node: ast.Name) -> Typed:
        kind = self.scope.local(node)
        if kind is not None:
            if isinstance(kind, Unknown):
                raise refuse(node, "", known=kind)
            return ast.Name(node.id, ast.Load()), kind
        return self.literal(node, self.scope.outside(node))

    def _attribute(self, node: ast.Attribute) -> Typed:
        made, kind = self.expression(node.value)
        if isinstance(kind, Meta):
            return self.literal(node, self.scope.member(node, kind.value))
        if isinstance(kind, Record):
            fields = kind.fields
            if node.attr not in fields:
                hint = did_you_mean(node.attr, fields, "field")
                raise refuse(node, f"{kind.kind.__name__} has no field {node.attr}", hint)
            if isinstance(fields[node.attr], Unknown):
                raise refuse(
                    node, f"the field {node.attr} has no type that can be compiled", "declare it float, int or bool"
                )
            return ast.Attribute(made, node.attr, ast.Load()), fields[node.attr]
        raise refuse(node, f"{described(kind)} has no {node.attr}", _METHODS.get(node.attr, ""), known=kind)

    def _tuple(self, node: ast.Tuple) -> Typed:
        parts = [self.expression(part) for part in node.elts]
        for part, (_, kind) in zip(node.elts, parts, strict=True):
            if isinstance(kind, Meta):
                raise refuse(part, f"{described(kind)} is no value")
        return ast.Tuple([made for made, _ in parts], ast.Load()), TupleOf(tuple(kind for _, kind in parts))

    def _unaryop(self, node: ast.UnaryOp) -> Typed:
        if isinstance(node.op, ast.Not):
            return ast.UnaryOp(node.op, self.test(node.operand)), bool
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant):
            value = node.operand.value
            if isinstance(value, int | float):
                return self.literal(node, -value)
        made, kind = self.number(node.operand)
        if kind is float:
            if isinstance(node.op, ast.Invert):
                raise refuse(node, "~ of a number", "~ is of integers")
            return (made if isinstance(node.op, ast.UAdd) else ast.UnaryOp(node.op, made)), float
        made = self.as_integer(made, kind)
        if isinstance(node.op, ast.USub):
            return self.checked(operations.NEGATE, made), int
        return (made if isinstance(node.op, ast.UAdd) else ast.UnaryOp(node.op, made)), int

    def _binop(self, node: ast.BinOp) -> Typed:
        left = self.number(node.left)
        return self.operated(node, type(node.op), left, self.number(node.right))

    def operated(self, node: ast.AST, operator: type[ast.operator], left: Typed, right: Typed) -> Typed:
        """Two numbers joined by an operator."""
        (a, first), (b, second) = left, right
        if float not in (first, second):
            if operator in operations.BITWISE:
                both = bool if first is second is bool else int
                sides = (a, b) if both is bool else (self.as_integer(a, first), self.as_integer(b, second))
                return ast.BinOp(sides[0], operator(), sides[1]), both
            a, b = self.as_integer(a, first), self.as_integer(b, second)
            if operator is ast.Pow and isinstance(b, ast.Constant) and b.value < 0:  # type: ignore[operator]
                return self._power(a, first, b, second), float
            if _surely_succeeds(operator, b):
                return ast.BinOp(a, operator(), b), int
            if operator in operations.OF_INTEGERS:
                operation = operations.OF_INTEGERS[operator]
                return self.checked(operation, a, b), operation.result
        elif operator is ast.Pow:
            return self._power(a, first, b, second), float
        elif operator in operations.PLAIN:
            return ast.BinOp(self.as_number(a, first), operator(), self.as_number(b, second)), float
        elif operator in operations.OF_NUMBERS:
            a, b = self.as_number(a, first), self.as_number(b, second)
            if operator is ast.Div and isinstance(b, ast.Constant) and b.value != 0:
                return ast.BinOp(a, operator(), b), float
            return self.checked(operations.OF_NUMBERS[operator], a, b), float
        if operator is ast.MatMult:
            raise refuse(node, "@ is of matrices", "write loops over the entries")
        raise refuse(node, "bits of a number", "the operators of bits are of integers: write int(...)")

    def _power(self, a: ast.expr, first: Type, b: ast.expr, second: Type) -> ast.expr:
        return self.defined(operations.POWER, self.as_number(a, first), self.as_number(b, second))

    def _boolop(self, node: ast.BoolOp) -> Typed:
        return self._joined(node, self.number)

    def _joined(self, node: ast.BoolOp, read: Callable[[ast.expr], Typed]) -> Typed:
        """`and` or `or`: the rest is evaluated only where it decides."""
        parts = [self.apart(lambda part=part: read(part)) for part in node.values]  # type: ignore[misc]
        values, kind = self.agreed(node, [typed for _, typed in parts], "the value is")
        if not any(lines for lines, _ in parts[1:]):
            self.lines += parts[0][0]
            return ast.BoolOp(node.op, values), kind
        name = self.scope.fresh()
        held = ast.Name(name, ast.Load())
        inner: list[ast.stmt] = []
        for (lines, _), value in reversed(list(zip(parts[1:], values[1:], strict=True))):
            goes_on = held if isinstance(node.op, ast.And) else ast.UnaryOp(ast.Not(), held)
            inner = [ast.If(goes_on, [*lines, _assign(name, value), *inner], [])]
        self.lines += [*parts[0][0], _assign(name, values[0]), *inner]
        return held, kind

    def _ifexp(self, node: ast.IfExp) -> Typed:
        test = self.test(node.test)
        then, first = self.apart(lambda: self.expression(node.body))
        other, second = self.apart(lambda: self.expression(node.orelse))
        (a, b), kind = self.agreed(node, [first, second], "the value is")
        if not then and not other:
            return ast.IfExp(test, a, b), kind
        name = self.scope.fresh()
        self.lines.append(ast.If(test, [*then, _assign(name, a)], [*other, _assign(name, b)]))
        return ast.Name(name, ast.Load()), kind

    def _compare(self, node: ast.Compare) -> Typed:
        for operator in node.ops:
            if isinstance(operator, ast.Is | ast.IsNot | ast.In | ast.NotIn):
                raise refuse(node, "is and in are not compiled", "compare with == and or")
        left = self.number(node.left)
        first = self.number(node.comparators[0])
        read = [self.apart(lambda part=part: self.number(part)) for part in node.comparators[1:]]  # type: ignore[misc]
        rest = [first, *(typed for _, typed in read)]
        if any(lines for lines, _ in read):
            return self._chain(node, left, rest, [lines for lines, _ in read]), bool
        if all(not _apart(a, b) for a, b in zip([left, *rest], rest, strict=False)):
            return ast.Compare(left[0], node.ops, [made for made, _ in rest]), bool
        names = [(self.kept(made), kind) for made, kind in (left, *rest)]
        pairs = zip(names, node.ops, names[1:], strict=False)
        tests = [self._compared(a, operator, b) for a, operator, b in pairs]
        return (tests[0] if len(tests) == 1 else ast.BoolOp(ast.And(), tests)), bool

    def _chain(self, node: ast.Compare, left: Typed, rest: list[Typed], lines: list[list[ast.stmt]]) -> ast.expr:
        """Comparisons in a row, of which the later ones are evaluated only where the earlier hold."""
        held = self.scope.fresh()
        before, made = [self.kept(left[0]), self.kept(rest[0][0])], list[list[ast.stmt]]()
        a: Typed = before[1], rest[0][1]
        self.lines.append(_assign(held, self._compared((before[0], left[1]), node.ops[0], a)))
        for (value, kind), operator, own in zip(rest[1:], node.ops[1:], lines, strict=True):

            def step(a: Typed = a, value: ast.expr = value, kind: Type = kind, operator: ast.cmpop = operator) -> Typed:
                b: Typed = self.kept(value), kind
                self.lines.append(_assign(held, self._compared(a, operator, b)))
                return b

            inner, a = self.apart(step)
            made.append([*own, *inner])
        nested: list[ast.stmt] = []
        for each in reversed(made):
            nested = [ast.If(ast.Name(held, ast.Load()), [*each, *nested], [])]
        self.lines += nested
        return ast.Name(held, ast.Load())

    def _compared(self, left: Typed, operator: ast.cmpop, right: Typed) -> ast.expr:
        """A comparison, exact of integers with numbers."""
        if not _apart(left, right) or not self.compiled:
            return ast.Compare(left[0], [operator], [right[0]])
        turned = left[1] is float
        (a, kind), (b, _) = (right, left) if turned else (left, right)
        order = self.applied(arithmetic.compare, self.as_integer(a, kind), b)
        if isinstance(operator, ast.Eq | ast.NotEq):
            return ast.Compare(order, [operator], [ast.Constant(0)])
        less = isinstance(operator, ast.Lt | ast.LtE) != turned
        ends = [ast.Constant(-1 if less else 1)]
        ends += [ast.Constant(0)] if isinstance(operator, ast.LtE | ast.GtE) else []
        kept = self.kept(order)
        tests: list[ast.expr] = [ast.Compare(kept, [ast.Eq()], [end]) for end in ends]
        return tests[0] if len(tests) == 1 else ast.BoolOp(ast.Or(), tests)

    def _subscript(self, node: ast.Subscript) -> Typed:
        made, kind = self.expression(node.value)
        if isinstance(node.slice, ast.Slice):
            raise refuse(node, "a part of a list", "write a loop over its entries")
        if isinstance(kind, TupleOf) and isinstance(node.slice, ast.Constant | ast.UnaryOp):
            index = _known(node.slice)
            if isinstance(index, int):
                if not -len(kind.entries) <= index < len(kind.entries):
                    raise refuse(node, f"there is no entry {index} in {described(kind)}")
                entry = kind.entries[index]
                return ast.Subscript(made, ast.Constant(index % len(kind.entries)), ast.Load()), entry
        return self.kept(ast.Subscript(made, self.index(node, made, kind), ast.Load())), self._entry(node, kind)

    def index(self, node: ast.Subscript, made: ast.expr, kind: Type) -> ast.expr:
        """The place of an entry that exists."""
        self._entry(node, kind)
        place, of = self.number(node.slice)
        if of is float:
            raise refuse(node.slice, "an index is an integer, and is given a number", "write int(...)")
        return self.checked(operations.PLACE, self.as_integer(place, of), self.applied(len, made))

    def _entry(self, node: ast.AST, kind: Type) -> Type:
        entry = entry_of(kind)
        if entry is None:
            message = f"{described(kind)} has no entries that an index may choose"
            hint = "make all its entries of one type" if isinstance(kind, TupleOf) else ""
            raise refuse(node, message, hint, known=kind)
        return entry

    def sequence(self, node: ast.expr) -> tuple[ast.expr, Type]:
        """What a loop goes over, and the type of an entry."""
        made, kind = self.expression(node)
        if not isinstance(kind, TupleOf | ListOf | Vector):
            raise refuse(
                node, f"a loop over {described(kind)}", "loops go over range(...), tuples and buffers", known=kind
            )
        return made, self._entry(node, kind)

    # -- calls -----------------------------------------------------------------------------------------------------

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
        made = self._known_function(node, target) if not node.keywords else None
        if made is not None:
            return made
        raise refuse(node, *_no_function(node, target))

    def _replaced(self, node: ast.Call, function: ast.Attribute) -> Typed:
        made, kind = self.expression(function.value)
        if not isinstance(kind, Record):
            raise refuse(node, f"{described(kind)} has no _replace", known=kind)
        new = {keyword.arg: keyword.value for keyword in node.keywords}
        for name in new:
            if name not in kind.fields:
                raise refuse(
                    node, f"{kind.kind.__name__} has no field {name}", did_you_mean(str(name), kind.fields, "field")
                )
        given = {name: self.expression(value) for name, value in new.items()}
        rest = {name: (ast.Attribute(made, name, ast.Load()), of) for name, of in kind.fields.items()}
        return self._made(node, kind, rest | given)  # type: ignore[operator]

    def _record(self, node: ast.Call, kind: Any) -> Typed:
        names, defaults = list(kind._fields), kind._field_defaults
        if any(isinstance(part, ast.Starred) for part in node.args) or any(k.arg is None for k in node.keywords):
            raise refuse(node, "* in a call", f"write the fields: {', '.join(names)}")
        given = dict(zip(names, node.args, strict=False)) | {str(k.arg): k.value for k in node.keywords}
        missing = [name for name in names if name not in given and name not in defaults]
        if missing or len(node.args) > len(names) or not set(given) <= set(names):
            raise refuse(node, f"{kind.__name__} is given other fields than it has", f"its fields: {', '.join(names)}")
        read = {name: self.expression(value) for name, value in given.items()}
        read |= {name: self.literal(node, defaults[name]) for name in names if name not in given}
        return self._made(node, Record(kind), read)

    def _made(self, node: ast.AST, kind: Record, values: dict[str, Typed]) -> Typed:
        fields = kind.fields
        made = [self.converted(node, *values[n], of, f"the field {n}") for n, of in fields.items()]
        return ast.Call(self.bound(kind.kind), made, []), kind

    def _known_function(self, node: ast.Call, target: Any) -> Typed | None:
        if target is len and len(node.args) == 1:
            made, _ = self.sequence(node.args[0])
            return self.applied(len, made), int
        if target not in _OF_NUMBERS or any(isinstance(part, ast.Starred) for part in node.args):
            return None
        if target in (min, max) and len(node.args) == 1:
            raise refuse(node, f"{target.__name__}() of a list is not compiled", "compare its entries in a loop")
        given = [self.number(part) for part in node.args]
        if target in (min, max):
            return self._extreme(node, target, given)
        if target in (pow, math.pow) and len(given) == 2:
            if target is math.pow:
                return self.defined(operations.TWO[math.pow], *self._numbers(given)), float
            return self.operated(node, ast.Pow, *given)
        if target is divmod and len(given) == 2:
            kept = [(self.kept(made), kind) for made, kind in given]
            parts = [self.operated(node, sign, *kept) for sign in (ast.FloorDiv, ast.Mod)]
            return ast.Tuple([made for made, _ in parts], ast.Load()), TupleOf(tuple(kind for _, kind in parts))
        if target is math.log and len(given) == 2:
            parts = [(self.defined(operations.ONE[math.log], self.as_number(*part)), float) for part in given]
            return self.operated(node, ast.Div, *parts)
        if target in operations.TWO and len(given) == 2:
            return self._of_numbers(target, operations.TWO[target], given), float
        if target in operations.OF_WHOLE and len(given) == operations.OF_WHOLE[target][0]:
            if any(kind is float for _, kind in given):
                raise refuse(node, f"{target.__name__} of a number", "it is of integers")
            return self.checked(operations.OF_WHOLE[target][1], *(self.as_integer(*part) for part in given)), int
        return self._of_one(node, target, *given[0]) if len(given) == 1 else None

    def _of_one(self, node: ast.Call, target: Any, made: ast.expr, kind: Type) -> Typed | None:
        if target in operations.ONE:
            return self._of_numbers(target, operations.ONE[target], [(made, kind)]), float
        if target in operations.LOOKS:
            return self.applied(target, self.as_number(made, kind)), bool
        if target in operations.SCALED:
            return ast.BinOp(self.as_number(made, kind), ast.Mult(), ast.Constant(operations.SCALED[target])), float
        if target is math.fabs:
            return self.applied(abs, self.as_number(made, kind)), float
        if target is float:
            return self.as_number(made, kind), float
        if target is bool:
            return (made if kind is bool else ast.Compare(made, [ast.NotEq()], [ast.Constant(0)])), bool
        whole: dict[Any, Checked] = {int: operations.TRUNCATE, round: operations.NEAREST, **operations.ROUND}
        if target in whole:
            return (self.checked(whole[target], made) if kind is float else self.as_integer(made, kind)), int
        if target is abs:
            if kind is float:
                return self.applied(abs, made), float
            return self.checked(operations.ABSOLUTE, self.as_integer(made, kind)), int
        return None

    def _numbers(self, given: Iterable[Typed]) -> list[ast.expr]:
        return [self.as_number(made, kind) for made, kind in given]

    def _of_numbers(self, target: Any, operation: Checked, given: Sequence[Typed]) -> ast.expr:
        if target in operations.NEVER_FAIL:
            return self.applied(target, *self._numbers(given))
        return self.defined(operation, *self._numbers(given))

    def _extreme(self, node: ast.Call, target: Any, given: Sequence[Typed]) -> Typed:
        """The first of the least or greatest, as Python compares them."""
        values, kind = self.agreed(node, given, f"{target.__name__}() is of")
        if not self.compiled:
            return ast.Call(self.bound(target), values, []), kind
        sign = ast.Lt() if target is min else ast.Gt()
        best = self.kept(values[0])
        for value in values[1:]:
            other = self.kept(value)
            best = self.kept(ast.IfExp(ast.Compare(other, [sign], [best]), other, best))
        return best, kind


def _assign(name: str, value: ast.expr) -> ast.stmt:
    return ast.Assign([ast.Name(name, ast.Store())], value)


def _surely_succeeds(operator: type[ast.operator], b: ast.expr) -> bool:
    """Whether an operation of integers always has a value, since its second operand is written out."""
    if not isinstance(b, ast.Constant) or not isinstance(b.value, int):
        return False
    shifts = operator is ast.RShift and 0 <= b.value <= 63
    return shifts or (operator in (ast.FloorDiv, ast.Mod) and b.value not in (0, -1))


def _apart(left: Typed, right: Typed) -> bool:
    """Whether one is an integer and the other a number, so that the integer may not be exact as a number."""
    if float not in (left[1], right[1]) or left[1] is right[1]:
        return False
    whole = left[0] if right[1] is float else right[0]
    kind = left[1] if right[1] is float else right[1]
    known = isinstance(whole, ast.Constant) and abs(whole.value) <= _SURELY_EXACT  # type: ignore[arg-type]
    return kind is int and not known


def _known(node: ast.expr) -> Any:
    try:
        return ast.literal_eval(node)
    except ValueError:
        return None


def _no_function(node: ast.Call, target: Any) -> tuple[str, str]:
    """Why something cannot be called, and what to write."""
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


def _not_compiled(node: ast.AST) -> tuple[str, str]:
    """Why an expression is refused, and what to write."""
    return RefusedError.CONSTRUCTS.get(
        type(node).__name__, (f"{type(node).__name__} is not compiled", "write it with numbers")
    )


_METHODS = {"append": "declare a Buffer, and write buffer[place] = value", "sum": "add the entries up in a loop"}
_OF_NUMBERS: set[Any] = {
    *operations.ONE,
    *operations.TWO,
    *operations.OF_WHOLE,
    *operations.LOOKS,
    *operations.SCALED,
    *operations.ROUND,
    *(abs, bool, divmod, float, int, max, min, pow, round, math.fabs),
}
