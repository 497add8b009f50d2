"""A program with its derivatives in one direction: beside every number stands its slope (forward
mode; Griewank and Walther 2008, chapter 3).

    f(x), dx  ->  f(x), f'(x) dx

Operations have the rules of `tangent_rules`. Entries of an array at a place that moves have no
derivative: their slope is NaN.

Slopes that are zero wherever a program runs are not computed: a function is written once for each
choice of parameters that move.
"""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from proofmass.runner.program import form
from proofmass.runner.program.build import Builder, parameters_like
from proofmass.runner.program.tangent_rules import (
    NO_SLOPE,
    OF_FUNCTIONS,
    OF_OPERATIONS,
    SlopeArithmetic,
    TangentRule,
    TangentStep,
)
from proofmass.runner.program.walk import statements

MovingParameters: TypeAlias = tuple[bool, ...]  # of parameters, whether they have a slope


def moves(kind: form.Kind) -> bool:
    """Return whether numbers of a kind have slopes."""
    return kind is not form.TRUTH


class Tangents:
    """Functions with slopes, each written once for each choice of what moves."""

    def __init__(self, own: Mapping[str, TangentRule] | None = None, beside: Sequence[form.Storage] = ()) -> None:
        """Take rules by operations and origins of functions, beside those of rounding and of elementary functions.

        They may use arrays of the entry that are `beside`, which pass through every function with
        slopes; what calls functions with own rules has slopes, whether its parameters move or not.
        """
        self.rules, self.beside = {**OF_FUNCTIONS, **(own or {})}, beside
        self.operations = {
            **OF_OPERATIONS,
            **{name: rule for name, rule in self.rules.items() if name in OF_OPERATIONS},
        }
        self.lowered: dict[Any, Any] = {}
        self._own = frozenset(own or ())
        self._made: dict[tuple[form.Function, MovingParameters], form.Function] = {}
        self._entered: dict[form.Function, bool] = {}

    def entered(self, function: form.Function) -> bool:
        """Return whether a function calls one with an own rule."""
        if function not in self._entered:
            called = [each.function for each in statements(function.body) if isinstance(each, form.Call)]
            self._entered[function] = any(
                isinstance(each, form.Function) and (each.origin in self._own or self.entered(each)) for each in called
            )
        return self._entered[function]

    def of(self, function: form.Function, moving: MovingParameters) -> form.Function:
        """Return a function whose parameters have their slopes behind them where they move, and so have its results."""
        key = function, moving
        if key not in self._made:
            self._made[key] = TangentWriter(self, function, moving).written(f"{function.name}_slopes_{len(self._made)}")
        return self._made[key]


class TangentWriter:
    """Writes one function, again and again until it is known which variables have slopes."""

    def __init__(self, tangents: Tangents, function: form.Function, moving: MovingParameters) -> None:
        self.tangents, self.function, self.moving = tangents, function, moving
        self._known = set[form.Variable]()

    def written(self, name: str) -> form.Function:
        """Return the function with slopes."""
        while True:
            before = len(self._known)
            made = self._attempt(name)
            if len(self._known) == before:
                return made

    def _attempt(self, name: str) -> form.Function:
        self.builder = Builder(name, self.function.origin, self.function.inline)
        self.builder.lowered = self.tangents.lowered
        self.arithmetic = SlopeArithmetic(self.builder)
        self.copies: dict[
            Any, Any
        ] = {}  # values, variables and arrays of the function, as they are called in the new one
        self.slopes: dict[Any, Any] = {}  # of the values, variables and arrays of the function
        for parameter, moving in zip(self.function.parameters, self.moving, strict=True):
            self._parameter(parameter, moving)
        self.beside = [
            self.copies.get(array) or parameters_like(self.builder, array.name, array) for array in self.tangents.beside
        ]
        for variable in self.function.variables:
            self.copies[variable] = self.builder.variable(variable.kind, variable.name)
            if variable in self._known:
                self.slopes[variable] = self.builder.variable(form.FLOAT, f"{variable.name}_slope")
        self._region(self.function.body)
        return self.builder.function()

    def _parameter(self, parameter: form.Value | form.Storage, moving: bool) -> None:
        self.copies[parameter] = parameters_like(self.builder, parameter.name, parameter)
        if moving and isinstance(parameter, form.Storage):
            self.slopes[parameter] = self.builder.array(form.FLOAT, parameter.length, f"{parameter.name}_slope", True)
        elif moving:
            self.slopes[parameter] = self.builder.parameter(form.FLOAT, f"{parameter.name}_slope")

    # -- statements --------------------------------------------------------------------------------

    def copied(self, value: Any) -> Any:
        """An operand or array of the function, as the new one calls it."""
        return self.copies.get(value, value)

    def slope(self, value: form.Operand) -> form.Operand:
        """The slope of an operand."""
        found: form.Operand = self.slopes.get(value, NO_SLOPE) if isinstance(value, form.Value) else NO_SLOPE
        return found

    def _region(self, region: form.Region) -> None:
        for statement in region:
            self.builder.line = statement.line
            self._statement(statement)

    def _statement(self, statement: form.Statement) -> None:
        builder, copied = self.builder, self.copied
        match statement:
            case form.Compute(result, operation, operands):
                given = [copied(value) for value in operands]
                made = builder.compute(operation, *given, name=result.name)
                self.copies[result] = made
                slopes = [self.slope(value) for value in operands]
                if any(slope is not NO_SLOPE for slope in slopes):
                    self._put(result, self.tangents.operations[operation](self._step(given, slopes, made)))
            case form.Get(result, variable):
                self.copies[result] = builder.get(copied(variable))
                if variable in self.slopes:
                    self._put(result, builder.get(self.slopes[variable]))
            case form.Set(variable, value):
                builder.set(copied(variable), copied(value))
                slope = self.slope(value)
                if variable in self.slopes:
                    builder.set(self.slopes[variable], slope)
                elif slope is not NO_SLOPE:  # what has been written before does not know it
                    self._known.add(variable)
                    self.slopes[variable] = builder.variable(form.FLOAT, f"{variable.name}_slope")
            case form.Load(result, array, index):
                self.copies[result] = builder.load(copied(array), copied(index), result.name)
                slope = builder.load(self.slopes[array], copied(index)) if array in self.slopes else NO_SLOPE
                self._put(result, self.arithmetic.plus(slope, self.arithmetic.undefined(self.slope(index))))
            case form.Store(array, index, value):
                builder.store(copied(array), copied(index), copied(value))
                if array in self.slopes:
                    slope = self.arithmetic.plus(self.slope(value), self.arithmetic.undefined(self.slope(index)))
                    builder.store(self.slopes[array], copied(index), slope)
            case form.View(part, whole, first):
                self.copies[part] = builder.view(copied(whole), copied(first), part.length, part.name)
                if whole in self.slopes:
                    self.slopes[part] = builder.view(self.slopes[whole], copied(first), part.length)
            case form.Call():
                self._call(statement)
            case form.Return(values):
                results = list[form.Operand]()
                for value in values:
                    results += [copied(value), self.slope(value)] if moves(value.kind) else [copied(value)]
                builder.give(*results)
            case form.Break():
                builder.leave()
            case form.Continue():
                builder.next_turn()
            case _:
                self._structured(statement)

    def _structured(self, statement: form.Statement) -> None:
        builder, copied = self.builder, self.copied
        match statement:
            case form.If(condition, then, otherwise):
                with builder.when(copied(condition)):
                    self._region(then)
                with builder.otherwise():
                    self._region(otherwise)
            case form.For(counter, first, last, step, body):
                with builder.counted(copied(first), copied(last), step, counter.name) as turn:
                    self.copies[counter] = turn
                    self._region(body)
            case form.While(test, condition, body):
                with builder.within([]) as again:
                    self._region(test)
                with builder.within([]) as inner:
                    self._region(body)
                builder.add(form.While(again, copied(condition), inner, statement.line))

    def _step(self, x: Sequence[Any], dx: Sequence[form.Operand], y: form.Operand) -> TangentStep:
        return TangentStep(self.arithmetic, self.beside, x, dx, y)

    def _put(self, value: form.Value, slope: form.Operand) -> None:
        if slope is not NO_SLOPE:
            self.slopes[value] = slope

    # -- calls -------------------------------------------------------------------------------------

    def _call(self, statement: form.Call) -> None:
        function, copied, arguments = statement.function, self.copied, statement.arguments
        external = isinstance(function, form.External)
        rule = self.tangents.rules.get(function.symbol if isinstance(function, form.External) else function.origin)
        moving = tuple(argument in self.slopes for argument in arguments)
        if isinstance(function, form.Function) and rule is None and (any(moving) or self.tangents.entered(function)):
            given = [each for a in arguments for each in (copied(a), *([self.slopes[a]] if a in self.slopes else []))]
            made = iter(self.builder.call(self.tangents.of(function, moving), *given, *self.beside))
            for result in statement.results:
                self.copies[result] = next(made)
                if moves(result.kind):
                    self._put(result, next(made))
            return
        given = [copied(argument) for argument in arguments]
        results = self.builder.call(function, *given, names=[result.name for result in statement.results])
        self.copies.update(zip(statement.results, results, strict=True))
        slopes = [self.slope(argument) for argument in arguments if not isinstance(argument, form.Storage)]
        if rule is not None:
            self._put(statement.results[0], rule(self._step(given, slopes, results[0])))
        elif external:
            for result in statement.results:
                self._put(result, self.arithmetic.undefined(*slopes))
