"""Python expressions lowered into operations of a program."""

import ast
import types
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from proofmass.blocks.language.arithmetic import compare
from proofmass.blocks.language.operations import Checked
from proofmass.blocks.language.refusals import RefusedError, refuse
from proofmass.blocks.language.scope import MISSING, outer
from proofmass.blocks.language.values import is_record
from proofmass.runner.program import lower_numbers as numbers
from proofmass.runner.program.build import Builder, operand, zero
from proofmass.runner.program.form import (
    FLOAT,
    INTEGER,
    TRUTH,
    Compute,
    Get,
    If,
    Immediate,
    Kind,
    Load,
    Operand,
    Region,
    Statement,
    Storage,
    Value,
    Variable,
)
from proofmass.runner.program.structure import (
    Lowered,
    in_words,
    is_scalar,
    leaves,
    like,
    mapped,
    rebuilt,
    shape_of,
)

FAULT = "fault"
_DEAR = {"divide", "square_root", "floor_divide", "modulo"}  # too slow to be done in vain
_MANY = 12  # statements that must not run in vain


class WiderError(Exception):
    """A variable or result needs a wider kind than assumed, or a fault one of its own: the function is read again."""

    def __init__(self, name: str, kind: Kind) -> None:
        super().__init__(name)
        self.name, self.kind = name, kind


class LoweredExpressions:
    """Reads expressions of one function."""

    checked: Mapping[str, Checked] = {}  # operations that may fail, by name in a user's function
    fault: Variable | None = None  # whether anything failed

    def __init__(self, builder: Builder, function: types.FunctionType, local: frozenset[str]) -> None:
        self.builder, self.function, self.local = builder, function, local
        self.names: dict[str, Lowered] = {}  # of its variables; what changes is a `Variable`
        self.read: list[tuple[Any, str, Any]] = []  # values from outside: owner, name, value
        self.functions: list[str] = []  # names of those that it calls
        self.natural: set[Value] = set()  # integers that are not negative

    def expression(self, node: ast.expr) -> Lowered:
        """An expression; raises `RefusedError`."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            name = type(node).__name__
            raise refuse(node, *RefusedError.CONSTRUCTS.get(name, (f"{name} is not compiled", "write it with numbers")))
        return method(node)

    def number(self, node: ast.expr) -> Operand:
        """Lower an expression that must be a number."""
        return self._scalar(node, self.expression(node))

    def test(self, node: ast.expr) -> Operand:
        """Lower a condition."""
        if isinstance(node, ast.BoolOp):
            return self._joined(node, self.test)
        value = self.expression(node)
        if value is None or isinstance(value, tuple):
            return operand(bool(value))
        return numbers.as_kind(self.builder, self._scalar(node, value), TRUTH)

    def call(self, node: ast.AST, function: Any, arguments: Sequence[Lowered]) -> Lowered:
        """Result of a Python function for arguments."""
        raise NotImplementedError

    def _scalar(self, node: ast.AST, value: Lowered) -> Operand:
        if not is_scalar(value):
            raise refuse(node, f"{in_words(value)}, where a number is needed")
        return value  # type: ignore[no-any-return]

    def note(self, fault: Operand) -> None:
        """Note that something may have failed."""
        if self.fault is None:
            raise WiderError(FAULT, TRUTH)
        self.builder.set(self.fault, self.builder.compute("either", self.builder.get(self.fault), fault))

    # -- names and literals ------------------------------------------------------------------------

    def _constant(self, node: ast.Constant) -> Lowered:
        return self.known(node.value)

    def known(self, value: Any) -> Lowered:
        """Turn a Python value into a value of the program."""
        if isinstance(value, float | int):
            if isinstance(value, int) and not -(1 << 63) <= value < 1 << 64:
                raise OverflowError(f"{value} is an integer of more than 64 bits")
            if isinstance(value, int) and not isinstance(value, bool) and value >= 1 << 63:
                value -= 1 << 64
            return operand(value)
        if isinstance(value, tuple):
            return like(value, map(self.known, value))
        return value

    def _name(self, node: ast.Name) -> Lowered:
        if node.id in self.names:
            return mapped(self.names[node.id], self._now)
        if node.id in self.local:
            raise refuse(node, f"{node.id} may have no value here", f"give it one before: {node.id} = 0.0")
        value = self.checked.get(node.id) or outer(self.function, node.id)
        if value is MISSING:
            raise refuse(node, f"there is no {node.id}", "define or import it")
        self.read.append((self.function, node.id, value))
        return self.known(value)

    def _now(self, held: Any) -> Any:
        return self.builder.get(held) if isinstance(held, Variable) else held

    def _attribute(self, node: ast.Attribute) -> Lowered:
        owner = self.expression(node.value)
        if isinstance(owner, types.ModuleType):
            value = getattr(owner, node.attr, MISSING)
            if value is MISSING:
                raise refuse(node, f"{owner.__name__} has no {node.attr}")
            self.read.append((owner, node.attr, value))
            return self.known(value)
        if is_record(type(owner)) and node.attr in owner._fields:
            return getattr(owner, node.attr)
        raise refuse(node, f"{in_words(owner)} has no {node.attr}")

    def _tuple(self, node: ast.Tuple) -> Lowered:
        return tuple(map(self.expression, node.elts))

    # -- operators ---------------------------------------------------------------------------------

    def _unaryop(self, node: ast.UnaryOp) -> Operand:
        if isinstance(node.op, ast.Not):
            return self.builder.compute("not", self.test(node.operand))
        value = self.number(node.operand)
        if isinstance(node.op, ast.Invert):
            return self.builder.compute("xor", numbers.as_kind(self.builder, value, INTEGER), -1)
        if isinstance(node.op, ast.USub):
            return numbers.negated(self.builder, value)
        return numbers.as_kind(self.builder, value, INTEGER) if value.kind is TRUTH else value

    def _binop(self, node: ast.BinOp) -> Lowered:
        a = self.number(node.left)
        return self.operated(node, type(node.op), a, self.number(node.right))

    def operated(self, node: ast.AST, operator: type[ast.operator], a: Operand, b: Operand) -> Operand:
        """Apply an operator to two numbers."""
        whole = FLOAT not in (a.kind, b.kind)
        value = numbers.operated(self.builder, operator, a, b)
        if value is None:
            function = numbers.FUNCTIONS.get((operator, whole))
            if function is None:
                raise refuse(node, "bits of a number", "the operators of bits are of integers: write int(...)")
            kind = INTEGER if whole else FLOAT
            operands = [numbers.as_kind(self.builder, part, kind) for part in (a, b)]
            made: Operand = self.call(node, function, operands)
            if whole or operator is ast.Pow:
                return made
            return self.builder.compute("select", self.builder.compute("equal", operands[1], 0.0), numbers.nan(), made)
        if isinstance(value, Value) and value.kind is INTEGER and self._is_natural(operator, a, b):
            self.natural.add(value)
        return value

    def _is_natural(self, operator: type[ast.operator], a: Operand, b: Operand) -> bool:
        """Return whether an integer is not negative because its operands are not."""
        if operator in (ast.Mod, ast.BitAnd) and self.is_natural(b):
            return True
        return operator in (ast.Add, ast.Mult, ast.FloorDiv, ast.RShift) and self.is_natural(a) and self.is_natural(b)

    def is_natural(self, value: Operand) -> bool:
        """Return whether an integer is known not to be negative."""
        return value.value >= 0 if isinstance(value, Immediate) else value in self.natural

    # -- conditions --------------------------------------------------------------------------------

    def _boolop(self, node: ast.BoolOp) -> Operand:
        return self._joined(node, self.number)

    def _joined(self, node: ast.BoolOp, read: Callable[[ast.expr], Operand]) -> Operand:
        """Lower `and` or `or`: the rest is evaluated only if it decides."""
        first, goes_on = read(node.values[0]), isinstance(node.op, ast.And)
        for part in node.values[1:]:
            decides = numbers.as_kind(self.builder, first, TRUTH)
            if isinstance(decides, Immediate):
                first = read(part) if decides.value is goes_on else first
                continue
            rest, region = self._apart(lambda part=part: read(part))  # type: ignore[misc]
            if first.kind is rest.kind is TRUTH and is_cheap(region):
                self.builder.splice(region)
                first = self.builder.compute("both" if goes_on else "either", first, rest)
            elif goes_on:
                first = self._either(decides, rest, region, first, [])
            else:
                first = self._either(decides, first, [], rest, region)
        return first

    def _ifexp(self, node: ast.IfExp) -> Lowered:
        test = self.test(node.test)
        if isinstance(test, Immediate):
            return self.expression(node.body if test.value else node.orelse)
        a, then = self._apart(lambda: self.expression(node.body))
        b, other = self._apart(lambda: self.expression(node.orelse))
        if is_scalar(a) and is_scalar(b):
            return self._either(test, a, then, b, other)
        return self._either_of_many(node, test, a, then, b, other)

    def _either(self, test: Operand, a: Operand, then: Region, b: Operand, other: Region) -> Operand:
        """Choose one of two numbers; compute both where that is cheaper than a branch."""
        kind = numbers.widest(a.kind, b.kind)
        if is_cheap(then, other):
            self.builder.splice(then)
            self.builder.splice(other)
            return self.chosen(test, *numbers.agreed(self.builder, a, b))
        variable = self.builder.variable(kind)
        self._branches(test, [variable], [a], then, [b], other)
        return self.builder.get(variable)

    def chosen(self, test: Operand, a: Operand, b: Operand) -> Operand:
        """Choose one of two numbers of one kind."""
        made = self.builder.compute("select", test, a, b)
        if isinstance(made, Value) and self.is_natural(a) and self.is_natural(b):
            self.natural.add(made)
        return made

    def _either_of_many(
        self, node: ast.AST, test: Operand, a: Lowered, then: Region, b: Lowered, other: Region
    ) -> Lowered:
        """Choose one of two tuples."""
        first, second = list(leaves(a)), list(leaves(b))
        arrays = any(isinstance(part, Storage) for part in (*first, *second))
        if type(a) is not type(b) or len(first) != len(second) or (arrays and first != second):
            raise refuse(node, f"{in_words(a)} in one case and {in_words(b)} in another")
        if arrays:
            return a
        kinds = [numbers.widest(x.kind, y.kind) for x, y in zip(first, second, strict=True)]
        variables = [self.builder.variable(kind) for kind in kinds]
        self._branches(test, variables, first, then, second, other)
        return rebuilt(a, map(self.builder.get, variables))

    def _branches(
        self,
        test: Operand,
        variables: Sequence[Variable],
        a: Sequence[Any],
        then: Region,
        b: Sequence[Any],
        other: Region,
    ) -> None:
        node = If(test, then, other, self.builder.line)
        for region, values in ((then, a), (other, b)):
            with self.builder.within(region):
                for variable, value in zip(variables, values, strict=True):
                    self.builder.set(variable, numbers.as_kind(self.builder, value, variable.kind))
        self.builder.add(node)

    def _apart(self, read: Callable[[], Lowered]) -> tuple[Lowered, Region]:
        """Lower a value, and return it with its statements, which are not written yet."""
        with self.builder.within([]) as region:
            value = read()
        return value, region

    def _compare(self, node: ast.Compare) -> Operand:
        return self._chain(node, self.expression(node.left), list(zip(node.ops, node.comparators, strict=True)))

    def _chain(self, node: ast.Compare, left: Lowered, rest: Sequence[tuple[ast.cmpop, ast.expr]]) -> Operand:
        """Lower comparisons: the later ones are evaluated only if the first holds."""
        right, holds = self._pair(node, left, *rest[0])
        if len(rest) == 1 or (isinstance(holds, Immediate) and not holds.value):
            return holds
        others, region = self._apart(lambda: self._chain(node, right, rest[1:]))
        if is_cheap(region):
            self.builder.splice(region)
            return self.builder.compute("both", holds, others)
        return self._either(holds, others, region, zero(TRUTH), [])

    def _pair(self, node: ast.Compare, left: Lowered, operator: ast.cmpop, part: ast.expr) -> tuple[Lowered, Operand]:
        """Lower the right side of a comparison, and return it and whether the comparison holds."""
        right = self.expression(part)
        if isinstance(operator, ast.Is | ast.IsNot):
            raise refuse(node, "is is not compiled", "compare with ==")
        if isinstance(operator, ast.In | ast.NotIn):
            if not isinstance(right, tuple):
                raise refuse(node, "in is of tuples", "compare with == and or")
            among = operand(False)
            for entry in right:
                equal = self._compared(node, ast.Eq, left, entry)
                among = self.builder.compute("either", among, equal)
            return right, among if isinstance(operator, ast.In) else self.builder.compute("not", among)
        return right, self._compared(node, type(operator), left, right)

    def _compared(self, node: ast.AST, operator: type[ast.cmpop], left: Lowered, right: Lowered) -> Operand:
        a, b = self._scalar(node, left), self._scalar(node, right)
        if not numbers.needs_comparing(a, b):
            return numbers.compared(self.builder, operator, a, b)

        turned = a.kind is FLOAT
        order = self.call(node, compare, (b, a) if turned else (a, b))
        if turned:  # -1 and 1 change places; 2 stands for a NaN
            order = self.builder.compute(
                "select", self.builder.compute("equal_integers", order, 2), 2, numbers.negated(self.builder, order)
            )
        is_nan = self.builder.compute("equal_integers", order, 2)
        holds = numbers.compared(self.builder, operator, order, operand(0))
        known = operand(operator is ast.NotEq)
        return self.builder.compute("select", is_nan, known, holds)

    # -- entries -----------------------------------------------------------------------------------

    def _subscript(self, node: ast.Subscript) -> Lowered:
        whole = self.expression(node.value)
        if isinstance(node.slice, ast.Slice):
            raise refuse(node, "a part of a list", "write a loop over its entries")
        if isinstance(whole, Storage):
            return self.builder.load(whole, self.index(whole, self.number(node.slice)))
        if not isinstance(whole, tuple):
            raise refuse(node, f"{in_words(whole)} has no entries")
        return self.entry(node, whole, self.number(node.slice))

    def entry(self, node: ast.AST, whole: tuple[Lowered, ...], index: Operand) -> Lowered:
        """An entry of a tuple."""
        place = numbers.as_index(index)
        if place is not None:
            if not -len(whole) <= place < len(whole):
                raise refuse(node, f"there is no entry {place} among {len(whole)}")
            return whole[place]
        parts = [list(leaves(part)) for part in whole]
        alike = len(set(map(shape_of, whole))) == 1
        if not whole or not all(is_scalar(leaf) for part in parts for leaf in part):
            raise refuse(node, f"{in_words(whole)} has no entries that an index may choose")
        if not alike and not all(map(is_scalar, whole)):
            raise refuse(node, f"{in_words(whole)} has entries of several types", "make all its entries of one type")
        return rebuilt(whole[0], [self._entry(index, column) for column in zip(*parts, strict=True)])

    def _entry(self, index: Operand, entries: Sequence[Any]) -> Operand:
        """Number that an index selects."""
        parts = numbers.agreed(self.builder, *entries)
        chosen = parts[0]
        for number, part in enumerate(parts[1:], 1):
            chosen = self.builder.compute("select", self._is(index, number, len(parts)), part, chosen)
        return chosen

    def _is(self, index: Operand, number: int, length: int) -> Operand:
        same = self.builder.compute("equal_integers", index, number)
        if self.is_natural(index):
            return same
        return self.builder.compute("either", same, self.builder.compute("equal_integers", index, number - length))

    def index(self, whole: Storage, index: Operand) -> Operand:
        """The place of an entry: counted from the end where the index is negative."""
        known = numbers.as_index(index)
        if known is not None and known >= 0:
            return index
        index = numbers.as_kind(self.builder, index, INTEGER)
        if self.is_natural(index) or whole.length is None:  # nothing is counted from an end that is not known
            return index
        behind = self.builder.compute("add_integers", index, whole.length)
        return self.builder.compute("select", self.builder.compute("less_integers", index, 0), behind, index)


def is_cheap(*regions: Region) -> bool:
    """Return whether all statements of some regions together are so cheap that they may always be executed."""
    return sum(map(len, regions)) <= _MANY and all(_costs_little(s) for region in regions for s in region)


def _costs_little(statement: Statement) -> bool:
    match statement:
        case Compute(_, operation):
            return operation not in _DEAR
        case Get() | Load(_, _, Immediate()):
            return True
    return False
