"""Typed programs written by hand, a statement a call, for tests of the form and of the targets."""

from collections.abc import Iterator
from contextlib import contextmanager

from proofmass.runner.program.form import (
    FLOAT,
    INTEGER,
    OPERATIONS,
    TRUTH,
    Array,
    Break,
    Call,
    Compute,
    Constant,
    Continue,
    External,
    For,
    Function,
    Get,
    If,
    Kind,
    Load,
    Operand,
    Program,
    Region,
    Return,
    Set,
    Statement,
    Store,
    Value,
    Variable,
    View,
    While,
)

Number = Operand | float | int | bool


def number(value: Number) -> Operand:
    """An operand; numbers of Python become constants of their kind."""
    if isinstance(value, Value | Constant):
        return value
    return Constant({float: FLOAT, int: INTEGER, bool: TRUTH}[type(value)], value)


def program(*functions: Function) -> Program:
    """A program of functions, the entry last."""
    return Program({function.name: function for function in functions})


class Writer:
    """Writes a function, region by region."""

    def __init__(self, name: str, *parameters: Value | Array, results: tuple[Kind, ...] = (), inline: bool = False):
        self.function = Function(name, parameters, results, inline=inline)
        self.region: Region = self.function.body

    def say(self, statement: Statement) -> None:
        """A statement as it is."""
        self.region.append(statement)

    def do(self, operation: str, *operands: Number, name: str = "") -> Value:
        """The result of an operation."""
        read = tuple(number(operand) for operand in operands)
        result = Value(OPERATIONS[operation].result or read[-1].kind, name)
        self.say(Compute(result, operation, read))
        return result

    def variable(self, kind: Kind, name: str = "") -> Variable:
        """A new variable of the function."""
        variable = Variable(kind, name)
        self.function.variables.append(variable)
        return variable

    def get(self, variable: Variable) -> Value:
        """What a variable is."""
        result = Value(variable.kind, variable.name)
        self.say(Get(result, variable))
        return result

    def set(self, variable: Variable, value: Number) -> None:
        """A variable becomes a value."""
        self.say(Set(variable, number(value)))

    def load(self, array: Array, index: Number) -> Value:
        """An entry of an array."""
        result = Value(array.entry, array.name)
        self.say(Load(result, array, number(index)))
        return result

    def store(self, array: Array, index: Number, value: Number) -> None:
        """An entry of an array becomes a value."""
        self.say(Store(array, number(index), number(value)))

    def view(self, whole: Array, first: Number, length: int | None) -> Array:
        """A part of an array."""
        part = Array(whole.entry, length, whole.writable, "part")
        self.say(View(part, whole, number(first)))
        return part

    def call(self, function: Function | External, *arguments: Number | Array) -> tuple[Value, ...]:
        """What a function returns."""
        if isinstance(function, External):
            kinds = () if function.result is None else (function.result,)
        else:
            kinds = function.results
        results = tuple(Value(kind) for kind in kinds)
        read = tuple(a if isinstance(a, Array) else number(a) for a in arguments)
        self.say(Call(results, function, read))
        return results

    def leave(self, *values: Number) -> None:
        """Return."""
        self.say(Return(tuple(number(value) for value in values)))

    def stop(self) -> None:
        """Break."""
        self.say(Break())

    def skip(self) -> None:
        """Continue."""
        self.say(Continue())

    @contextmanager
    def into(self, region: Region) -> Iterator[None]:
        """Statements go into this region."""
        outer, self.region = self.region, region
        yield
        self.region = outer

    @contextmanager
    def when(self, condition: Number) -> Iterator[Region]:
        """Statements that are done under a condition; yields the other region."""
        statement = If(number(condition), [], [])
        self.say(statement)
        with self.into(statement.then):
            yield statement.otherwise

    @contextmanager
    def count(self, first: Number, last: Number, step: int = 1) -> Iterator[Value]:
        """Statements that are done for a counter."""
        statement = For(Value(INTEGER, "i"), number(first), number(last), step, [])
        self.say(statement)
        with self.into(statement.body):
            yield statement.counter

    @contextmanager
    def loop(self, test: Region, condition: Number) -> Iterator[None]:
        """Statements that are done as long as a condition holds."""
        statement = While(test, number(condition), [])
        self.say(statement)
        with self.into(statement.body):
            yield
