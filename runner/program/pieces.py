"""Pieces of the generated loop: names, numbers that it is given, calls of the functions of blocks."""

import math
import typing
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeVar, assert_never

from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.declaration.arguments import meaning_of
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.language.forms import constants_form, form_of
from proofmass.graphs.checks.schedule import Node
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.bindings import (
    Buffer,
    Default,
    Deviate,
    Out,
    Parameters,
    State,
    Tick,
    Time,
    Wire,
    bound,
)
from proofmass.runner.plan.keys import (
    ConstantOf,
    DuplicateKeyError,
    Given,
    Moving,
    ParameterOf,
    StreamOf,
    made_up,
    variable,
    word,
)
from proofmass.runner.plan.planned import Plan

K = TypeVar("K", bound=Given | Moving)
FLOATS, INTEGERS = "numbers", "integers"
_NAN = "(1e308 * 10.0 - 1e308 * 10.0)"


@dataclass
class Slots(Generic[K]):
    """Numbers that travel between a run and the loop in two arrays, one of floats and one of integers.

    With lanes each number has a place for every lane, one beside the other.
    """

    prefix: str
    lanes: int = 0
    kinds: dict[K, tuple[type, int]] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=lambda: {FLOATS: 0, INTEGERS: 0})

    def add(self, key: K, kind: type) -> str:
        """A place for one number; returns the expression that reads it. Raises `DuplicateKeyError`."""
        if key in self.kinds:
            raise DuplicateKeyError(key)
        self.kinds[key] = (kind, self.counts[array(kind)])
        self.counts[array(kind)] += 1
        return self.read(key)

    def read(self, key: K) -> str:
        """The expression that reads a number."""
        kind, _ = self.kinds[key]
        return f"{self.write(key)} != 0" if kind is bool else self.write(key)

    def write(self, key: K) -> str:
        """The place to which a number is written back."""
        kind, index = self.kinds[key]
        return self.at(array(kind), index)

    def at(self, array: str, index: int) -> str:
        """A place by its array and number."""
        return f"{self.prefix}{array}[{f'{index * self.lanes} + lane' if self.lanes else index}]"


@dataclass(frozen=True)
class Call:
    """A call in the source; one that `fails` gives its value and whether anything in it failed."""

    text: str
    fails: bool


class Pieces:
    """What every part of the generator writes with; it collects names and numbers as they are used."""

    def __init__(self, plan: Plan, lanes: int = 0) -> None:
        self.plan, self.lanes = plan, lanes
        self.names: dict[str, Any] = {}
        self.constants: Slots[Given] = Slots("", lanes)
        self.memory: Slots[Moving] = Slots("state_", lanes)
        self.values: dict[Given, Any] = {}
        self.refuses = False  # whether the loop has the flag `refused`: a function failed, a value left its format
        self.flags: set[str] = set()  # variables that are integers and no wire's

    def call(self, name: str, function: str, port: str) -> "Call":
        """The call of a function of a block."""
        block = self.plan.blocks[name]
        behaviour = type(block).output_functions.get(function) or type(block).functions[function]
        known = not self.plan.is_driven(name) or behaviour.reads_constants
        constants = made_up(word(name), "c") if known else "0"  # that come later in the tick
        arguments = [constants, *(self.argument(name, port, a) for a in behaviour.arguments)]
        return self.called(name, function, behaviour, arguments)

    def called(self, name: str, role: str, behaviour: Behaviour, arguments: Iterable[str]) -> "Call":
        """The call of a function of a block with these arguments."""
        block = self.plan.blocks[name]
        form = form_of(type(block), behaviour, compiled=True)
        function = self.named(block, role, form.function if form else behaviour.function)
        return Call(f"{function}({', '.join(arguments)})", form is not None and form.fails)

    def kept(self, name: str, function: str, target: str, call: "Call", flag: str = "refused") -> Iterator[str]:
        """Lines that keep what a call gives in `target`, where there is one; a fault in it is added to `flag`."""
        if not call.fails:
            yield f"{target} = {call.text}" if target else call.text
            return
        self.refuses |= flag == "refused"
        fault = made_up(variable((name, function)), "fault")
        self.flags.add(fault)
        yield f"{target or '_'}, {fault} = {call.text}"
        yield f"{flag} |= {fault}"

    def number(self, call: "Call") -> str:
        """The expression of a number that a call gives: NaN where anything failed in it."""
        if not call.fails:
            return call.text
        self.names["number_or_nan"] = number_or_nan
        return f"number_or_nan({call.text})"

    def argument(self, name: str, port: str, argument: str) -> str:
        """The expression that a function of a block is given for an argument."""
        block = self.plan.blocks[name]
        binding = bound(self.plan.schedule, block, name, port, argument, meaning_of(argument, type(block).buffers))
        match binding:
            case State():
                return made_up(word(name), "x")
            case Parameters():
                return "0"  # known to the integer code
            case Time():
                return "time"
            case Tick(divisor):
                return "tick" if divisor == 1 else f"tick // {divisor}"
            case Deviate():
                return made_up(word(name), "normal")
            case Out(node) | Buffer(node) | Wire(node):
                return variable(node)
            case Default(_, value):
                return repr(value)
            case _:
                assert_never(binding)

    def driven(self, name: str, flag: str = "refused") -> Iterator[str]:
        """Lines that make the constants of a block from its parameters; a fault in it is added to `flag`."""
        block, drivers = self.plan.blocks[name], self.plan.schedule.drivers
        made = type(block).parameters_class()
        values = [
            variable(drivers[name, p]) if (name, p) in drivers else self.parameter(name, p) for p, _ in fields(made)
        ]
        parameters = f"{self.named(block, 'Parameters', made)}({', '.join(values)})"
        call = Call(parameters, False)
        if "constants" in type(block).functions:
            form = constants_form(type(block), compiled=True)
            behaviour = type(block).functions["constants"]
            function = self.named(block, "constants", form.function if form else behaviour.function)
            given = [parameters, made_up(word(name), "period")][: 1 + len(behaviour.arguments)]
            call = Call(f"{function}({', '.join(given)})", form is not None and form.fails)
        return self.kept(name, "constants", made_up(word(name), "c"), call, flag)

    def parameter(self, name: str, parameter: str) -> str:
        """The variable of a parameter that is not driven, of a block whose constants the loop makes."""
        return made_up(variable((name, parameter)), "set")

    def within_bounds(self, name: str) -> Iterator[str]:
        """Lines that end the run where a driven parameter leaves the bounds that its block declares."""
        drivers = self.plan.schedule.drivers
        for p, declared in type(self.plan.blocks[name]).parameters.items():
            limits = ((">", declared.above), (">=", declared.at_least), ("<", declared.below), ("<=", declared.at_most))
            if (name, p) in drivers:
                value = variable(drivers[name, p])
                for sign, limit in limits:
                    if limit is not None:
                        yield f"not_finite += 0.0 if {value} {sign} {float(limit)!r} else {_NAN}"

    def deviate(self, name: str) -> str:
        """The line that draws the deviate of a block."""
        self.names["normal_deviate"] = normal_deviate
        return f"{made_up(word(name), 'normal')} = normal_deviate(seed, run, {', '.join(self.stream_and_sample(name))})"

    def stream_and_sample(self, name: str) -> tuple[str, str]:
        """What besides seed and run the deviate of a block follows from."""
        divisor = self.plan.schedule.divisors[name]
        stream = self.constant(StreamOf(name), int, self.plan.stream(name))
        return stream, "tick" if divisor == 1 else f"tick // {divisor}"

    def constant(self, key: Given, kind: Any, value: Any) -> str:
        """The expression that reads a number which the loop is given, or a tuple of them."""
        if isinstance(value, tuple):
            return f"({''.join(self.constant(key, of, entry) + ', ' for key, of, entry in parts(key, kind, value))})"
        self.values[key] = value
        return self.constants.add(key, kind)

    def named(self, block: Any, role: str, value: Any) -> str:
        """A name for a function or class of a kind of block; two kinds may bear the same name, and any letters."""
        kind = type(block).__name__
        first = kind[0].upper() if kind[0].isalpha() else f"K{kind[0]}"
        name = plain = f"{first}{kind[1:]}__{role}"
        number = 1
        while self.names.setdefault(name, value) is not value:
            number += 1
            name = f"{plain}_{number}"
        return name


def fields(made: Any) -> list[tuple[str, type]]:
    return list(made.__annotations__.items())


def parts(key: Given, kind: Any, values: tuple[Any, ...]) -> list[tuple[ConstantOf | ParameterOf, Any, Any]]:
    """The entries of a tuple among constants or parameters, each with its key and type."""
    assert isinstance(key, ConstantOf | ParameterOf)
    kinds = typing.get_args(kind) or ((float,) if kind is tuple else (kind,))
    kinds = kinds[:1] * len(values) if len(kinds) < 2 or kinds[1] is Ellipsis else kinds
    entries = zip(kinds, values, strict=True)
    return [(replace(key, entries=(*key.entries, i)), held_as(of), value) for i, (of, value) in enumerate(entries)]


def numbers_of(constants: Any, key_of: Callable[[str], ConstantOf | ParameterOf]) -> dict[Given, Any]:
    """The numbers of constants by their keys, tuples among them by their entries."""
    found = dict[Given, Any]()
    left = [(key_of(f), kind, v) for (f, kind), v in zip(fields(type(constants)), constants, strict=True)]
    while left:
        key, kind, value = left.pop()
        if isinstance(value, tuple):
            left += parts(key, kind, value)
        else:
            found[key] = value
    return found


def number_or_nan(found: tuple[float, bool]) -> float:
    """What a function gives; NaN where anything failed in it."""
    return math.nan if found[1] else found[0]


def spoilt(value: float, failed: bool) -> float:
    """A number; NaN where anything failed of what was computed with it."""
    return math.nan if failed else value


def array(kind: type) -> str:
    return FLOATS if kind is float else INTEGERS


def entries(node: Node, shape: tuple[int, ...]) -> list[str]:
    """The numbers that a wire holds."""
    return [f"{variable(node)}[{i}]" for i in range(shape[0])] if shape else [variable(node)]
