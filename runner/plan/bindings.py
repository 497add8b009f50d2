"""Bindings: each argument of a block's functions bound to its place in a graph.

Every engine has one `match` over `Binding`; a type checker finds those that forget a new one.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.checks.schedule import Schedule
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.fixed.step_formats import held_as


@dataclass(frozen=True, slots=True)
class StateBinding:
    """The whole state of a block."""

    block: str


@dataclass(frozen=True, slots=True)
class Parameters:
    """The parameters of a block whose constants are in registers."""

    block: str


@dataclass(frozen=True, slots=True)
class Out:
    """The vector into which a function writes its output."""

    node: Endpoint


@dataclass(frozen=True, slots=True)
class Time:
    """Seconds since the start."""


@dataclass(frozen=True, slots=True)
class Tick:
    """Ticks of a block since its first: base ticks after `phase` over `divisor`, rounded down."""

    divisor: int
    phase: int = 0


@dataclass(frozen=True, slots=True)
class Deviate:
    """A standard normal deviate, a fresh one in each tick of the block."""

    block: str
    divisor: int
    phase: int = 0


@dataclass(frozen=True, slots=True)
class BufferBinding:
    """A vector of state, updated in place."""

    node: Endpoint  # the block and its buffer


@dataclass(frozen=True, slots=True)
class WireBinding:
    """The value of the output at the other end of an input's wire."""

    node: Endpoint


@dataclass(frozen=True, slots=True)
class Default:
    """The value of an input that is not connected."""

    node: Endpoint  # the block and its input
    value: float = field(compare=False)  # 0.0, -0.0 and False are equal, and not the same


Binding: TypeAlias = StateBinding | Parameters | Out | Time | Tick | Deviate | BufferBinding | WireBinding | Default


def bindings(schedule: Schedule, block: Block, name: str, port: str, behaviour: Behaviour) -> Iterator[Binding]:
    """Yield the binding of each argument of a function; constants, the first argument, have none.

    `name` is that of the block in its graph, `port` the output the function computes, if it does.
    """
    for argument, meaning in zip(behaviour.arguments, behaviour.meanings, strict=True):
        yield bound(schedule, block, name, port, argument, meaning)


def bound(schedule: Schedule, block: Block, name: str, port: str, argument: str, meaning: Meaning) -> Binding:
    """Return the binding of one argument of a function."""
    match meaning:
        case Meaning.STATE:
            return StateBinding(name)
        case Meaning.PARAMETERS:
            return Parameters(name)
        case Meaning.OUT:
            return Out((name, port))
        case Meaning.TIME:
            return Time()
        case Meaning.TICK:
            return Tick(*schedule.beat(name))
        case Meaning.DEVIATE:
            node = (name, argument)
            return Default(node, 0.0) if schedule.without_noise else Deviate(name, *schedule.beat(name))
        case Meaning.BUFFER:
            return BufferBinding((name, argument))
        case Meaning.INPUT:
            driver = schedule.drivers.get((name, argument))
            return WireBinding(driver) if driver else _default(block, name, argument)
        case Meaning.PERIOD:
            raise ValueError(f"{name}: constants and start alone are made from the period")


def _default(block: Block, name: str, argument: str) -> Default:
    declared = type(block).inputs[argument]
    assert declared.default is not None, f"{name}.{argument} is not connected: the check refuses that"
    return Default((name, argument), held_as(declared.dtype)(declared.default))
