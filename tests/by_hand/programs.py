"""Typed programs written by hand, a statement a call, for tests of the form and of the targets."""

from collections.abc import Iterator
from contextlib import contextmanager

from proofmass.runner.program import form

Number = form.Operand | float | int | bool


def number(value: Number) -> form.Operand:
    """An operand; numbers of Python become constants of their kind."""
    if isinstance(value, form.Value | form.Immediate):
        return value
    return form.Immediate({float: form.FLOAT, int: form.INTEGER, bool: form.TRUTH}[type(value)], value)


def program(*functions: form.Function) -> form.Program:
    """A program of functions, the entry last."""
    return form.Program({function.name: function for function in functions})


class Writer:
    """Writes a function, region by region."""

    def __init__(
        self,
        name: str,
        *parameters: form.Value | form.Storage,
        results: tuple[form.Kind, ...] = (),
        inline: bool = False,
    ):
        self.function = form.Function(name, parameters, results, inline=inline)
        self.region: form.Region = self.function.body

    def say(self, statement: form.Statement) -> None:
        """A statement as it is."""
        self.region.append(statement)

    def do(self, operation: str, *operands: Number, name: str = "") -> form.Value:
        """The result of an operation."""
        read = tuple(number(operand) for operand in operands)
        result = form.Value(form.OPERATIONS[operation].result or read[-1].kind, name)
        self.say(form.Compute(result, operation, read))
        return result

    def variable(self, kind: form.Kind, name: str = "") -> form.Variable:
        """A new variable of the function."""
        variable = form.Variable(kind, name)
        self.function.variables.append(variable)
        return variable

    def get(self, variable: form.Variable) -> form.Value:
        """What a variable is."""
        result = form.Value(variable.kind, variable.name)
        self.say(form.Get(result, variable))
        return result

    def set(self, variable: form.Variable, value: Number) -> None:
        """A variable becomes a value."""
        self.say(form.Set(variable, number(value)))

    def load(self, array: form.Storage, index: Number) -> form.Value:
        """An entry of an array."""
        result = form.Value(array.entry, array.name)
        self.say(form.Load(result, array, number(index)))
        return result

    def store(self, array: form.Storage, index: Number, value: Number) -> None:
        """An entry of an array becomes a value."""
        self.say(form.Store(array, number(index), number(value)))

    def view(self, whole: form.Storage, first: Number, length: int | None) -> form.Storage:
        """A part of an array."""
        part = form.Storage(whole.entry, length, whole.writable, "part")
        self.say(form.View(part, whole, number(first)))
        return part

    def call(
        self, function: form.Function | form.External, *arguments: Number | form.Storage
    ) -> tuple[form.Value, ...]:
        """What a function returns."""
        if isinstance(function, form.External):
            kinds = () if function.result is None else (function.result,)
        else:
            kinds = function.results
        results = tuple(form.Value(kind) for kind in kinds)
        read = tuple(a if isinstance(a, form.Storage) else number(a) for a in arguments)
        self.say(form.Call(results, function, read))
        return results

    def leave(self, *values: Number) -> None:
        """Return."""
        self.say(form.Return(tuple(number(value) for value in values)))

    def stop(self) -> None:
        """Break."""
        self.say(form.Break())

    def skip(self) -> None:
        """Continue."""
        self.say(form.Continue())

    @contextmanager
    def into(self, region: form.Region) -> Iterator[None]:
        """Statements go into this region."""
        outer, self.region = self.region, region
        yield
        self.region = outer

    @contextmanager
    def when(self, condition: Number) -> Iterator[form.Region]:
        """Statements that are done under a condition; yields the other region."""
        statement = form.If(number(condition), [], [])
        self.say(statement)
        with self.into(statement.then):
            yield statement.otherwise

    @contextmanager
    def count(self, first: Number, last: Number, step: int = 1) -> Iterator[form.Value]:
        """Statements that are done for a counter."""
        statement = form.For(form.Value(form.INTEGER, "i"), number(first), number(last), step, [])
        self.say(statement)
        with self.into(statement.body):
            yield statement.counter

    @contextmanager
    def loop(self, test: form.Region, condition: Number) -> Iterator[None]:
        """Statements that are done as long as a condition holds."""
        statement = form.While(test, number(condition), [])
        self.say(statement)
        with self.into(statement.body):
            yield
