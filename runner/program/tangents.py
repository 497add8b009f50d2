"""A program with its derivatives in one direction: beside every number stands its slope (forward mode; Griewank and
Walther 2008, chapter 3).

    f(x), dx  ->  f(x), f'(x) dx

What a number means for slopes is what it means for dual numbers (`derivatives.dual`). Quantisers have the slope one:
conversions to integers, `truncate`, shifts, `rounding.round_half_even`, `rounding.round_down`, registers that wrap.
What is counted with has none: `floor`, `ceiling`, `rounding.nearest_integer`, comparisons. Bits of a number that moves,
and entries of an array at a place that moves, have no derivative: their slope is NaN. What is multiplied by a slope of
exactly 0 is nothing, whatever it is.

Slopes that are zero wherever a program runs are not computed: a function is written once for each choice of parameters
that move.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from proofmass.blocks.arithmetic import elementary, rounding
from proofmass.blocks.language import arithmetic
from proofmass.runner.derivatives.slopes import SLOPES_OF_ONE, SLOPES_OF_TWO
from proofmass.runner.program import form
from proofmass.runner.program.build import Builder
from proofmass.runner.program.lower import call
from proofmass.runner.program.lower_calls import LIBRARY
from proofmass.runner.program.structure import leaves
from proofmass.runner.program.walk import statements

MovingParameters: TypeAlias = tuple[bool, ...]  # of parameters, whether they have a slope
_NONE = form.Immediate(form.FLOAT, 0.0)
_UNDEFINED = form.Immediate(form.FLOAT, math.nan)


def moves(kind: form.Kind) -> bool:
    """Return whether numbers of a kind have slopes."""
    return kind is not form.TRUTH


def origin_of(function: Callable[..., Any]) -> str:
    """Return the origin that a function of Python has in programs."""
    return f"{function.__module__}.{function.__qualname__}"


class TangentStep(NamedTuple):
    """An operation or a call in a function that is being written: operands, their slopes, and its result."""

    writer: "TangentWriter"
    x: Sequence[Any]
    dx: Sequence[form.Operand]
    y: form.Operand

    def numbers(self) -> list[form.Operand]:
        """Return the operands as numbers."""
        return [self.writer.number(value) for value in self.x]


TangentRule: TypeAlias = Callable[[TangentStep], form.Operand]  # gives the slope of the result


class Tangents:
    """Functions with slopes, each written once for each choice of what moves."""

    def __init__(self, own: Mapping[str, TangentRule] | None = None, beside: Sequence[form.Storage] = ()) -> None:
        """Take rules by the origins of functions, beside those of rounding and of elementary functions.

        They may use arrays of the entry that are `beside`, which pass through every function with slopes; what calls
        functions with own rules has slopes, whether its parameters move or not.
        """
        self.rules, self.beside = {**_OF_FUNCTIONS, **(own or {})}, beside
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
        self.copies: dict[
            Any, Any
        ] = {}  # values, variables and arrays of the function, as they are called in the new one
        self.slopes: dict[Any, Any] = {}  # of the values, variables and arrays of the function
        for parameter, moving in zip(self.function.parameters, self.moving, strict=True):
            self._parameter(parameter, moving)
        self.beside = [
            self.copies.get(array) or self.builder.array(array.entry, array.length, array.name, array.writable)
            for array in self.tangents.beside
        ]
        for variable in self.function.variables:
            self.copies[variable] = self.builder.variable(variable.kind, variable.name)
            if variable in self._known:
                self.slopes[variable] = self.builder.variable(form.FLOAT, f"{variable.name}_slope")
        self._region(self.function.body)
        return self.builder.function()

    def _parameter(self, parameter: form.Value | form.Storage, moving: bool) -> None:
        builder = self.builder
        if isinstance(parameter, form.Storage):
            self.copies[parameter] = builder.array(
                parameter.entry, parameter.length, parameter.name, parameter.writable
            )
            if moving:
                self.slopes[parameter] = builder.array(form.FLOAT, parameter.length, f"{parameter.name}_slope", True)
            return
        self.copies[parameter] = builder.parameter(parameter.kind, parameter.name)
        if moving:
            self.slopes[parameter] = builder.parameter(form.FLOAT, f"{parameter.name}_slope")

    # -- statements --------------------------------------------------------------------------------------------------

    def copied(self, value: Any) -> Any:
        """An operand or array of the function, as the new one calls it."""
        return self.copies.get(value, value)

    def slope(self, value: form.Operand) -> form.Operand:
        """The slope of an operand."""
        found: form.Operand = self.slopes.get(value, _NONE) if isinstance(value, form.Value) else _NONE
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
                if moves(result.kind) and any(slope is not _NONE for slope in slopes):
                    self._put(result, _OPERATIONS[operation](TangentStep(self, given, slopes, made)))
            case form.Get(result, variable):
                self.copies[result] = builder.get(copied(variable))
                if variable in self.slopes:
                    self._put(result, builder.get(self.slopes[variable]))
            case form.Set(variable, value):
                builder.set(copied(variable), copied(value))
                slope = self.slope(value)
                if variable in self.slopes:
                    builder.set(self.slopes[variable], slope)
                elif slope is not _NONE:
                    self._known.add(variable)
            case form.Load(result, array, index):
                self.copies[result] = builder.load(copied(array), copied(index), result.name)
                slope = builder.load(self.slopes[array], copied(index)) if array in self.slopes else _NONE
                self._put(result, self.plus(slope, self.undefined(self.slope(index))))
            case form.Store(array, index, value):
                builder.store(copied(array), copied(index), copied(value))
                if array in self.slopes:
                    slope = self.plus(self.slope(value), self.undefined(self.slope(index)))
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
                with builder.within([]) as one:
                    self._region(then)
                with builder.within([]) as other:
                    self._region(otherwise)
                builder.add(form.If(copied(condition), one, other, statement.line))
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

    def _put(self, value: form.Value, slope: form.Operand) -> None:
        if slope is not _NONE:
            self.slopes[value] = slope

    # -- calls -------------------------------------------------------------------------------------------------------

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
            self._put(statement.results[0], rule(TangentStep(self, given, slopes, results[0])))
        elif external:
            for result in statement.results:
                self._put(result, self.undefined(*slopes))

    # -- arithmetic of slopes ----------------------------------------------------------------------------------------

    def plus(self, *slopes: form.Operand) -> form.Operand:
        """The sum of slopes."""
        total: form.Operand = _NONE
        for slope in slopes:
            if slope is not _NONE:
                total = slope if total is _NONE else self.builder.compute("add", total, slope)
        return total

    def minus(self, slope: form.Operand) -> form.Operand:
        """The slope with the other sign."""
        return _NONE if slope is _NONE else self.builder.compute("negate", slope)

    def times(self, slope: form.Operand, factor: form.Operand | float) -> form.Operand:
        """A factor times a slope; nothing where the slope is 0, whatever the factor."""
        if slope is _NONE:
            return _NONE
        product = self.builder.compute("multiply", slope, factor)
        if isinstance(factor, float | form.Immediate):
            return product
        return self.builder.compute("select", self.builder.compute("equal", slope, 0.0), 0.0, product)

    def over(self, slope: form.Operand, divisor: form.Operand) -> form.Operand:
        """A slope divided by a number."""
        return self.times(slope, self.builder.compute("divide", 1.0, divisor))

    def chosen(self, condition: form.Operand, slope: form.Operand, other: form.Operand) -> form.Operand:
        """One slope or the other."""
        return self.builder.compute("select", condition, slope, other)

    def undefined(self, *slopes: form.Operand) -> form.Operand:
        """No slope where all of some are 0, NaN elsewhere."""
        total = self.plus(*(self.builder.compute("absolute", slope) for slope in slopes if slope is not _NONE))
        if total is _NONE:
            return _NONE
        return self.builder.compute("select", self.builder.compute("equal", total, 0.0), 0.0, _UNDEFINED)

    def number(self, value: form.Operand) -> form.Operand:
        """A number or an integer as a number."""
        return value if value.kind is form.FLOAT else self.builder.compute("float_of_integer", value)


# -- rules: the slope of a result from its operands, their slopes, and itself -----------------------------------------


def _nothing(s: TangentStep) -> form.Operand:
    return _NONE


def _same(s: TangentStep) -> form.Operand:
    return s.dx[0]


def _unknown(s: TangentStep) -> form.Operand:
    return s.writer.undefined(*s.dx)


def _sum(s: TangentStep) -> form.Operand:
    return s.writer.plus(*s.dx)


def _difference(s: TangentStep) -> form.Operand:
    return s.writer.plus(s.dx[0], s.writer.minus(s.dx[1]))


def _product(s: TangentStep) -> form.Operand:
    w, (a, b) = s.writer, s.numbers()
    return w.plus(w.times(s.dx[0], b), w.times(s.dx[1], a))


def _quotient(s: TangentStep) -> form.Operand:
    w, (a, b) = s.writer, s.numbers()
    turned = w.times(w.minus(s.dx[1]), w.builder.compute("divide", a, b))
    return w.plus(w.over(s.dx[0], b), w.over(turned, b))


def _remainder(s: TangentStep) -> form.Operand:
    w = s.writer
    turns = w.number(w.builder.compute("floor_divide", *s.x))
    return w.plus(s.dx[0], w.minus(w.times(s.dx[1], turns)))


def _left_over(s: TangentStep) -> form.Operand:
    w = s.writer
    turns = w.builder.compute("truncate", w.builder.compute("divide", *s.x))
    return w.plus(s.dx[0], w.minus(w.times(s.dx[1], turns)))


def _opposite(s: TangentStep) -> form.Operand:
    return s.writer.minus(s.dx[0])


def _size(s: TangentStep) -> form.Operand:
    w, compute = s.writer, s.writer.builder.compute
    sided = w.chosen(compute("less", s.x[0], 0.0), w.minus(s.dx[0]), s.dx[0])
    return w.chosen(compute("equal", s.x[0], 0.0), w.undefined(s.dx[0]), sided)


def _signed(s: TangentStep) -> form.Operand:
    w = s.writer
    return w.chosen(w.builder.compute("equal", s.x[0], s.y), s.dx[0], w.minus(s.dx[0]))


def _root(s: TangentStep) -> form.Operand:
    return s.writer.times(s.dx[0], s.writer.builder.compute("divide", 0.5, s.y))


def _masked(s: TangentStep) -> form.Operand:
    """Return the slope of all bits, or of the low ones, as in a register that wraps. A parity is compared."""
    for mask, slope in ((_integer(s.x[1]), s.dx[0]), (_integer(s.x[0]), s.dx[1])):
        if mask == 1:
            return _NONE
        if mask >= -1 and mask and not mask & mask + 1:
            return slope
    return s.writer.undefined(*s.dx)


def _turned(s: TangentStep) -> form.Operand:
    """Return the slope with all bits turned, or the highest of a register that wraps, which is subtracted again."""
    for mask, slope in ((_integer(s.x[1]), s.dx[0]), (_integer(s.x[0]), s.dx[1])):
        if mask == -1:
            return s.writer.minus(slope)
        if mask > 0 and not mask & mask - 1:
            return slope
    return s.writer.undefined(*s.dx)


def _integer(value: form.Operand) -> int:
    """Return an integer that the program knows; 0, which takes all bits, for any other."""
    return int(value.value) if isinstance(value, form.Immediate) else 0


def _raised(s: TangentStep) -> form.Operand:
    w = s.writer
    return w.plus(w.times(s.dx[0], _scale(s)), w.undefined(s.dx[1]))


def _lowered(s: TangentStep) -> form.Operand:
    w = s.writer
    return w.plus(w.over(s.dx[0], _scale(s)), w.undefined(s.dx[1]))


def _scale(s: TangentStep) -> form.Operand:
    return s.writer.number(s.writer.builder.compute("shift_left", 1, s.x[1]))


def _selected(s: TangentStep) -> form.Operand:
    return s.writer.chosen(s.x[0], s.dx[1], s.dx[2])


_OPERATIONS: dict[str, TangentRule] = {
    **{name: _nothing for name, signature in form.OPERATIONS.items() if signature.result is form.TRUTH},
    **dict.fromkeys(("floor", "ceiling", "integer_of_truth", "float_of_truth"), _nothing),
    **dict.fromkeys(("truncate", "round_half_even", "float_of_integer", "integer_of_float"), _same),
    **dict.fromkeys(("or", "bits_of_float", "float_of_bits"), _unknown),
    **dict.fromkeys(("add", "add_integers"), _sum),
    **dict.fromkeys(("subtract", "subtract_integers"), _difference),
    **dict.fromkeys(("multiply", "multiply_integers"), _product),
    **dict.fromkeys(("divide", "floor_divide"), _quotient),
    "modulo": _remainder,
    "negate": _opposite,
    "absolute": _size,
    "copy_sign": _signed,
    "square_root": _root,
    "and": _masked,
    "xor": _turned,
    "shift_left": _raised,
    "shift_right": _lowered,
    "select": _selected,
}


def _chain(slopes_of: Callable[..., Any]) -> TangentRule:
    """Return the chain rule for derivatives that are functions of Python."""

    def rule(s: TangentStep) -> form.Operand:
        w, library = s.writer, LIBRARY.get(slopes_of)
        if all(slope is _NONE for slope in s.dx):
            return _NONE
        made = w.builder.call(library, *s.x) if library else leaves((call(w.builder, slopes_of, s.x),))
        factors = [each for each in made if not isinstance(each, form.Storage)]
        return w.plus(*(w.times(slope, factor) for slope, factor in zip(s.dx, factors, strict=True)))

    return rule


_OF_FUNCTIONS: dict[str, TangentRule] = {
    **{origin_of(function): _chain(slope) for function, slope in SLOPES_OF_ONE.items() if function not in LIBRARY},
    **{LIBRARY[function].symbol: _chain(slope) for function, slope in SLOPES_OF_ONE.items() if function in LIBRARY},
    **{origin_of(function): _chain(slopes) for function, slopes in SLOPES_OF_TWO.items()},
    "atan2": _chain(SLOPES_OF_TWO[elementary.arctangent2]),
    "pow": _chain(SLOPES_OF_TWO[elementary.power]),
    "fmod": _left_over,
    origin_of(rounding.round_half_even): _same,
    origin_of(rounding.round_down): _same,
    origin_of(rounding.wrapped): _same,
    origin_of(rounding.nearest_integer): _nothing,
    origin_of(arithmetic.number_floor_divide): _quotient,
}
