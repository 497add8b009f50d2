"""Pieces of the generated loop: names, numbers that it is given, calls of the functions of blocks."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from proofmass.blocks.counter_random import normal_deviate
from proofmass.graphs.schedule import Node
from proofmass.runner.engine.planned import Plan
from proofmass.runner.fixed.step_formats import held_as

FLOATS, INTEGERS = "numbers", "integers"
_NAN = "(1e308 * 10.0 - 1e308 * 10.0)"


@dataclass
class Slots:
    """Numbers that travel between a run and the loop in two arrays, one of floats and one of integers.

    With lanes each number has a place for every lane, one beside the other.
    """

    prefix: str
    lanes: int = 0
    kinds: dict[Any, tuple[type, int]] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=lambda: {FLOATS: 0, INTEGERS: 0})

    def add(self, key: Any, kind: type) -> str:
        """A place for one number; returns the expression that reads it."""
        self.kinds[key] = (kind, self.counts[array(kind)])
        self.counts[array(kind)] += 1
        return self.read(key)

    def read(self, key: Any) -> str:
        """The expression that reads a number."""
        kind, _ = self.kinds[key]
        return f"{self.write(key)} != 0" if kind is bool else self.write(key)

    def write(self, key: Any) -> str:
        """The place to which a number is written back."""
        kind, index = self.kinds[key]
        return self.at(array(kind), index)

    def at(self, array: str, index: int) -> str:
        """A place by its array and number."""
        return f"{self.prefix}{array}[{f'{index * self.lanes} + lane' if self.lanes else index}]"


class Pieces:
    """What every part of the generator writes with; it collects names and numbers as they are used."""

    def __init__(self, plan: Plan, lanes: int = 0) -> None:
        self.plan, self.lanes = plan, lanes
        self.names: dict[str, Any] = {}
        self.constants, self.memory = Slots("", lanes), Slots("state_", lanes)
        self.values: dict[Any, Any] = {}

    def call(self, name: str, function: str, port: str) -> str:
        block = self.plan.blocks[name]
        behaviour = block.output_functions.get(function) or block.functions[function]
        known = self.plan.constants[name] is not None or behaviour.reads_constants
        constants = f"{word(name)}__c" if known else "0"  # that come later in the tick
        arguments = [constants, *(self.argument(name, port, a) for a in behaviour.arguments)]
        return f"{self.named(block, function, behaviour.function)}({', '.join(arguments)})"

    def argument(self, name: str, port: str, argument: str) -> str:
        plan = self.plan
        block, divisor = plan.blocks[name], plan.schedule.divisors[name]
        fixed = {
            "x": f"{word(name)}__x",
            "out": f"{word(name)}__{port}",
            "time": "time",
            "normal": f"{word(name)}__normal",
            "p": "0",  # known to the integer code
        }
        if argument in fixed:
            return fixed[argument]
        if argument == "tick":
            return "tick" if divisor == 1 else f"tick // {divisor}"
        if argument in block.buffers:
            return f"{word(name)}__{argument}"
        driver = plan.schedule.drivers.get((name, argument))
        declared = block.inputs[argument]
        if driver is None:
            return repr(held_as(declared.dtype)(declared.default))  # type: ignore[arg-type]
        return variable(driver)

    def driven(self, name: str) -> str:
        block, drivers = self.plan.blocks[name], self.plan.schedule.drivers
        made = block.parameters_class()
        values = [
            variable(drivers[name, p]) if (name, p) in drivers else f"_{word(name)}__{p}" for p, _ in fields(made)
        ]
        parameters = f"{self.named(block, 'Parameters', made)}({', '.join(values)})"
        if "constants" not in block.functions:
            return f"{word(name)}__c = {parameters}"
        function = self.named(block, "constants", block.functions["constants"].function)
        return f"{word(name)}__c = {function}({parameters}, {word(name)}__period)"

    def within_bounds(self, name: str) -> Iterator[str]:
        """Lines that end the run where a driven parameter leaves the bounds that its block declares."""
        drivers = self.plan.schedule.drivers
        for p, declared in self.plan.blocks[name].parameters.items():
            limits = ((">", declared.above), (">=", declared.at_least), ("<", declared.below), ("<=", declared.at_most))
            if (name, p) in drivers:
                value = variable(drivers[name, p])
                for sign, limit in limits:
                    if limit is not None:
                        yield f"not_finite += 0.0 if {value} {sign} {float(limit)!r} else {_NAN}"

    def deviate(self, name: str) -> str:
        """The line that draws the deviate of a block."""
        self.names["normal_deviate"] = normal_deviate
        return f"{word(name)}__normal = normal_deviate(seed, run, {', '.join(self.stream_and_sample(name))})"

    def stream_and_sample(self, name: str) -> tuple[str, str]:
        """What besides seed and run the deviate of a block follows from."""
        divisor = self.plan.schedule.divisors[name]
        stream = self.constant((name, "stream"), int, self.plan.stream(name))
        return stream, "tick" if divisor == 1 else f"tick // {divisor}"

    def constant(self, key: Any, kind: type, value: Any) -> str:
        if isinstance(value, tuple):
            return f"({''.join(self.constant((*key, i), kind, entry) + ', ' for i, entry in enumerate(value))})"
        self.values[key] = value
        return self.constants.add(key, kind)

    def named(self, block: Any, role: str, value: Any) -> str:
        """A name for a function or class of a kind of block; two kinds may bear the same name, and any letters."""
        kind = type(block).__name__
        name = plain = f"{kind[0].upper()}{kind[1:]}__{role}"
        number = 1
        while self.names.setdefault(name, value) is not value:
            number += 1
            name = f"{plain}_{number}"
        return name


def fields(made: Any) -> list[tuple[str, type]]:
    return list(made.__annotations__.items())


def array(kind: type) -> str:
    return FLOATS if kind is float else INTEGERS


def word(name: str) -> str:
    """The name of a block as part of a variable's; no block lies inside another, so that two never agree."""
    return name.replace(".", "__")


def variable(node: Node) -> str:
    return f"{word(node[0])}__{node[1]}" if node[0] else node[1]


def entries(node: Node, shape: tuple[int, ...]) -> list[str]:
    """The numbers that a wire holds."""
    return [f"{variable(node)}[{i}]" for i in range(shape[0])] if shape else [variable(node)]
