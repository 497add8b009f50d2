"""Functions of a program, written statement by statement: scopes are contexts, constants are folded.

    builder = Builder("sum_of")
    x, n = builder.array(FLOAT, None, name="x"), builder.parameter(INTEGER, "n")
    total = builder.variable(FLOAT, "total", 0.0)
    with builder.counted(0, n) as i:
        builder.set(total, builder.compute("add", builder.get(total), builder.load(x, i)))
    builder.give(builder.get(total))
    function = builder.function()

A Python number stands for a constant. Formulas written for numbers run on `WrittenNumber` and are
written down.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

from proofmass.runner.program import form
from proofmass.runner.program.operations import EVALUATE
from proofmass.runner.program.structure import Lowered, like, mapped, named

BuilderInput: TypeAlias = form.Operand | float | int | bool  # what builders take for a value


class Builder:
    """Writes one function."""

    def __init__(self, name: str, origin: str = "", inline: bool = False) -> None:
        self.name, self.origin, self.inline = name, origin, inline
        self.line: form.Line | None = None  # of the next statement
        self.parameters: list[form.Value | form.Storage] = []
        self._variables: list[form.Variable] = []
        self._results: tuple[form.Kind, ...] | None = None
        self._region: form.Region = []
        self._body = self._region
        self.wholes: dict[form.Value, tuple[str, form.Operand]] = {}  # integers: the rounding and the number rounded
        self.lowered: dict[Any, Any] = {}  # functions of Python for functions of this program, shared with `beside`

    # -- what a function has -----------------------------------------------------------------------

    def parameter(self, kind: form.Kind, name: str) -> form.Value:
        """One more parameter."""
        value = form.Value(kind, name)
        self.parameters.append(value)
        return value

    def array(self, entry: form.Kind, length: int | None, name: str, writable: bool = False) -> form.Storage:
        """One more parameter that is an array."""
        array = form.Storage(entry, length, writable, name)
        self.parameters.append(array)
        return array

    def variable(self, kind: form.Kind, name: str = "", value: BuilderInput | None = None) -> form.Variable:
        """A variable, and its first value where that is given."""
        variable = form.Variable(kind, name)
        self._variables.append(variable)
        if value is not None:
            self.set(variable, value)
        return variable

    def function(self) -> form.Function:
        """Return the function. One with results returns zeros at its end, if reached."""
        results = self._results or ()
        if results and not always_returns(self._body):
            self._body.append(form.Return(tuple(zero(kind) for kind in results), self.line))
        return form.Function(
            self.name, tuple(self.parameters), results, self._body, self._variables, self.origin, self.inline
        )

    def beside(self, name: str, inline: bool = False) -> "Builder":
        """A builder of another function of the same program."""
        other = Builder(name, self.origin, inline)
        other.lowered = self.lowered
        return other

    # -- statements --------------------------------------------------------------------------------

    def compute(self, operation: str, *operands: BuilderInput, name: str = "") -> form.Operand:
        """An operation on values, folded where all of them are constants."""
        values = tuple(map(operand, operands))
        folded = _folded(operation, values)
        if folded is not None:
            return folded
        kind = form.OPERATIONS[operation].result or values[-1].kind
        result = form.Value(kind, name)
        self.add(form.Compute(result, operation, values, self.line))
        return result

    def likely(self, condition: BuilderInput, value: BuilderInput, other: BuilderInput) -> form.Operand:
        """Choose one of two numbers; the first is the likely one."""
        return self.compute("select", self.compute("likely", condition), value, other)

    def get(self, variable: form.Variable) -> form.Value:
        """Current value of a variable."""
        result = form.Value(variable.kind, variable.name)
        self.add(form.Get(result, variable, self.line))
        return result

    def set(self, variable: form.Variable, value: BuilderInput) -> None:
        """Set a variable."""
        self.add(form.Set(variable, operand(value), self.line))

    def load(self, array: form.Storage, index: BuilderInput, name: str = "") -> form.Value:
        """An entry of an array."""
        result = form.Value(array.entry, name)
        self.add(form.Load(result, array, operand(index), self.line))
        return result

    def store(self, array: form.Storage, index: BuilderInput, value: BuilderInput) -> None:
        """Set an entry of an array."""
        self.add(form.Store(array, operand(index), operand(value), self.line))

    def view(self, whole: form.Storage, first: BuilderInput, length: int | None, name: str = "") -> form.Storage:
        """A part of an array."""
        part = form.Storage(whole.entry, length, whole.writable, name or whole.name)
        self.add(form.View(part, whole, operand(first), self.line))
        return part

    def call(
        self,
        function: form.Function | form.External,
        *arguments: BuilderInput | form.Storage,
        names: Sequence[str] = (),
    ) -> tuple[form.Value, ...]:
        """Call a function and return its results."""
        if isinstance(function, form.External):
            kinds: tuple[form.Kind, ...] = () if function.result is None else (function.result,)
        else:
            kinds = function.results
        results = tuple(form.Value(kind, name) for kind, name in zip(kinds, [*names, *[""] * len(kinds)], strict=False))
        given = tuple(each if isinstance(each, form.Storage) else operand(each) for each in arguments)
        self.add(form.Call(results, function, given, self.line))
        return results

    def give(self, *values: BuilderInput) -> None:
        """Return from the function with these results."""
        results = tuple(map(operand, values))
        kinds = tuple(result.kind for result in results)
        if self._results is None:
            self._results = kinds
        assert self._results == kinds, "results of different kinds"
        self.add(form.Return(results, self.line))

    def leave(self) -> None:
        """Leave the innermost loop."""
        self.add(form.Break(self.line))

    def next_turn(self) -> None:
        """Continue with the next turn of the innermost loop."""
        self.add(form.Continue(self.line))

    def add(self, statement: form.Statement) -> None:
        """Append a statement here; write nothing where control never arrives."""
        if not self.ended:
            self._region.append(statement)

    # -- scopes ------------------------------------------------------------------------------------

    @property
    def ended(self) -> bool:
        """Return whether control never arrives here."""
        return bool(self._region) and never_ends(self._region[-1])

    @contextmanager
    def when(self, condition: BuilderInput) -> Iterator[None]:
        """Write the statements for a condition that holds; `otherwise` may follow."""
        node = form.If(operand(condition), [], [], self.line)
        with self.within(node.then):
            yield
        self.add(node)

    @contextmanager
    def otherwise(self) -> Iterator[None]:
        """Write the statements for the condition just before, where it does not hold."""
        node = self._region.pop()
        assert isinstance(node, form.If), "otherwise stands behind when"
        with self.within(node.otherwise):
            yield
        self._region.append(node)

    @contextmanager
    def counted(self, first: BuilderInput, last: BuilderInput, step: int = 1, name: str = "") -> Iterator[form.Value]:
        """Write a loop that counts, and yield its counter."""
        counter = form.Value(form.INTEGER, name)
        node = form.For(counter, operand(first), operand(last), step, [], self.line)
        with self.within(node.body):
            yield counter
        self.add(node)

    @contextmanager
    def repeated(self, condition: Callable[[], BuilderInput]) -> Iterator[None]:
        """Write a loop that runs as long as a condition holds; a function writes the condition."""
        test, body, line = form.Region(), form.Region(), self.line
        with self.within(test):
            holds = operand(condition())
        with self.within(body):
            yield
        self.add(form.While(test, holds, body, line))

    @contextmanager
    def within(self, region: form.Region) -> Iterator[form.Region]:
        """Write into a region of the caller's."""
        before, self._region = self._region, region
        try:
            yield region
        finally:
            self._region = before

    def splice(self, region: form.Region) -> None:
        """Append the statements of a region that was written separately."""
        for statement in region:
            self.add(statement)

    def number(self, value: BuilderInput) -> "WrittenNumber":
        """A value to compute with in a formula."""
        return WrittenNumber(self, operand(value))


class WrittenNumber:
    """A value of a function that is being written: sums and products of it are written down, not computed."""

    def __init__(self, builder: Builder, value: form.Operand) -> None:
        self.builder, self.value = builder, value

    def __add__(self, other: "WrittenNumber | float") -> "WrittenNumber":
        return self._with("add", self, other)

    def __mul__(self, other: "WrittenNumber | float") -> "WrittenNumber":
        return self._with("multiply", self, other)

    def __rmul__(self, other: float) -> "WrittenNumber":
        return self._with("multiply", other, self)

    def _with(self, operation: str, *given: "WrittenNumber | float") -> "WrittenNumber":
        operands = (each.value if isinstance(each, WrittenNumber) else float(each) for each in given)
        return WrittenNumber(self.builder, self.builder.compute(operation, *operands))


def parameters_like(builder: Builder, name: str, value: Lowered) -> Lowered:
    """Parameters of a function, of the same structure as a value of its caller."""
    if isinstance(value, tuple):
        return like(value, [parameters_like(builder, f"{name}_{of}", part) for of, part in named(value)])
    if isinstance(value, form.Storage):
        return builder.array(value.entry, value.length, name, value.writable)
    return mapped(value, lambda leaf: builder.parameter(leaf.kind, name))


def operand(value: BuilderInput) -> form.Operand:
    """Return a value of a program; a Python number becomes a constant."""
    if isinstance(value, form.Value | form.Immediate):
        return value
    if isinstance(value, bool):
        return form.Immediate(form.TRUTH, value)
    return form.Immediate(form.INTEGER, value) if isinstance(value, int) else form.Immediate(form.FLOAT, float(value))


def zero(kind: form.Kind) -> form.Immediate:
    """The zero of a kind."""
    return form.Immediate(kind, {form.FLOAT: 0.0, form.INTEGER: 0, form.TRUTH: False}[kind])


def always_returns(region: form.Region) -> bool:
    """Return whether control never reaches the end of a region."""
    return bool(region) and never_ends(region[-1])


def never_ends(statement: form.Statement) -> bool:
    """Return whether control never gets past a statement."""
    match statement:
        case form.Return() | form.Break() | form.Continue():
            return True
        case form.If(_, then, otherwise):
            return always_returns(then) and always_returns(otherwise)
        case form.While(_, form.Immediate(_, True), body):
            return not _leaves(body)
    return False


def _leaves(region: form.Region) -> bool:
    """Return whether a region, the body of a loop, may leave the loop."""
    for statement in region:
        match statement:
            case form.Break():
                return True
            case form.If(_, then, otherwise) if _leaves(then) or _leaves(otherwise):
                return True
    return False


def _folded(operation: str, operands: tuple[form.Operand, ...]) -> form.Operand | None:
    """Result of an operation if it is known beforehand: exact, and not NaN, whose bits differ between machines."""
    known = [operand.value for operand in operands if isinstance(operand, form.Immediate)]
    if len(known) == len(operands):
        value: Any = EVALUATE[operation](*known)
        kind = form.OPERATIONS[operation].result or operands[-1].kind
        return None if isinstance(value, float) and math.isnan(value) else form.Immediate(kind, value)
    if operation == "select":
        test, a, b = operands
        if isinstance(test, form.Immediate):
            return a if test.value else b
        return a if a is b else None
    return _neutral(operation, *operands) if len(operands) == 2 else None


def _neutral(operation: str, a: form.Operand, b: form.Operand) -> form.Operand | None:
    """Result of an operation on integers or truth values that one constant operand decides."""
    for constant, other, first in ((a, b, True), (b, a, False)):
        if not isinstance(constant, form.Immediate):
            continue
        match operation, constant.value:
            case ("both", True) | ("either", False):
                return other
            case ("both", False) | ("either", True):
                return constant
            case ("add_integers" | "or" | "xor", 0) | ("multiply_integers", 1):
                return other
            case ("multiply_integers", 0):
                return constant
            case ("subtract_integers" | "shift_left" | "shift_right", 0) if not first:
                return other
    return None
