"""Calls of the functions of blocks within a function that is being written, and the values of their arguments."""

from collections.abc import Callable, Sequence
from typing import Any, assert_never

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.language.forms import constants_form, form_of
from proofmass.graphs.checks.schedule import Beat
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.bindings import (
    Binding,
    BufferBinding,
    Default,
    Deviate,
    Out,
    Parameters,
    StateBinding,
    Tick,
    Time,
    WireBinding,
)
from proofmass.runner.plan.keys import VectorOf
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.build import Builder, operand
from proofmass.runner.program.form import FLOAT, TRUTH, Operand, Storage, Value, Variable
from proofmass.runner.program.lower import Called, outcome
from proofmass.runner.program.lower_numbers import KINDS, as_kind, nan
from proofmass.runner.program.slots import fields
from proofmass.runner.program.structure import Lowered, mapped


class Frame:
    """Values of wires, states and constants within one function of the program.

    What changes is a variable, which is read each time it is asked for.
    """

    def __init__(self, plan: Plan, builder: Builder) -> None:
        self.plan, self.builder = plan, builder
        self.wires: dict[VectorOf, Lowered] = {}  # buffers among them
        self.states: dict[str, Lowered] = {}
        self.constants: dict[str, Lowered] = {}
        self.parameters: dict[
            Endpoint, Lowered
        ] = {}  # those that are not driven, of blocks whose constants are made here
        self.periods: dict[str, Lowered] = {}  # of these blocks
        self.deviates: dict[str, Lowered] = {}
        self.time: Operand = operand(0.0)
        self.tick: Operand = operand(0)
        self.failed: Variable | None = None  # whether anything did, in a function of an instant

    # -- memory and wires --------------------------------------------------------------------------

    def now(self, held: Lowered) -> Lowered:
        """Current value of something that is kept."""
        return mapped(held, lambda leaf: self.builder.get(leaf) if isinstance(leaf, Variable) else leaf)

    def wire(self, node: Endpoint) -> Lowered:
        """Value of an output, or a buffer."""
        return self.now(self.wires[node])

    def set(self, target: Lowered, value: Lowered) -> None:
        """Set variables to values."""
        if isinstance(target, tuple):
            for place, part in zip(target, value, strict=True):
                self.set(place, part)
        else:
            self.builder.set(target, as_kind(self.builder, value, target.kind))

    def put(self, node: Endpoint, value: Lowered) -> None:
        """Set the value of an output from here on."""
        if isinstance(self.wires.get(node), Variable):
            self.set(self.wires[node], value)
        else:
            self.wires[node] = value

    # -- calls -------------------------------------------------------------------------------------

    def call(self, name: str, function: str) -> Called:
        """Call a function of a block, named by its role or by the output that it computes."""
        block = self.plan.blocks[name]
        behaviour = type(block).output_functions.get(function) or type(block).functions[function]
        return self.called(name, function, behaviour)

    def called(
        self, name: str, port: str, behaviour: Behaviour, argument: Callable[[Binding], Lowered] | None = None
    ) -> Called:
        """Call a function of a block, with or without a role."""
        block, bound = self.plan.blocks[name], self.plan.bound(name, port, behaviour)
        known = not self.plan.is_driven(name) or behaviour.reads_constants  # else they come later in the tick
        constants = self.now(self.constants[name]) if known else ()
        given = [constants, *map(argument or self.argument, bound)]
        form = form_of(type(block), behaviour)
        return outcome(self.builder, form.function if form else behaviour.function, given)

    def argument(self, binding: Binding) -> Lowered:
        """Value of an argument of a block's function."""
        match binding:
            case StateBinding(name):
                return self.now(self.states[name])
            case Parameters():
                return None  # known to the integer code
            case Time():
                return self.time
            case Tick(divisor, phase):
                return self.ticks(Beat(divisor, phase))
            case Deviate(name):
                return self.now(self.deviates[name])
            case Out(node) | BufferBinding(node) | WireBinding(node):
                return self.wire(node)
            case Default(_, value):
                return operand(value)
            case _:
                assert_never(binding)

    def ticks(self, beat: Beat) -> Operand:
        """Ticks of a block since its first one."""
        since = self.builder.compute("subtract_integers", self.tick, beat.phase) if beat.phase else self.tick
        return self.builder.compute("floor_divide", since, beat.stride) if beat.stride > 1 else since

    def driven(self, name: str) -> Called:
        """Compute the constants of a block from its parameters."""
        block, drivers = self.plan.blocks[name], self.plan.schedule.drivers
        record: Any = type(block).parameters_class()
        values = []
        for parameter, kind in fields(record):
            driver = drivers.get((name, parameter))
            value = self.now(self.parameters[name, parameter]) if driver is None else self.wire(driver)
            wanted = KINDS.get(held_as(kind))
            values.append(as_kind(self.builder, value, wanted) if wanted else value)
        parameters = record._make(values)
        if "constants" not in type(block).functions:
            return Called(parameters, None)
        form, behaviour = constants_form(type(block)), type(block).functions["constants"]
        given = behaviour.named({"period": self.now(self.periods[name])})
        return outcome(self.builder, form.function if form else behaviour.function, [parameters, *given])

    def number(self, outcome: Called) -> Operand:
        """Number that a call returns: NaN if anything failed in it."""
        value = as_kind(self.builder, outcome.value, FLOAT)
        return value if outcome.fault is None else self._unless(outcome.fault, value)

    def sound(self, outcome: Called) -> Lowered:
        """Result of a call within an instant; a fault is noted."""
        if outcome.fault is not None:
            if self.failed is None:
                self.failed = self.builder.variable(TRUTH, "failed")
            either = self.builder.compute("either", self.builder.get(self.failed), outcome.fault)
            self.builder.set(self.failed, either)
        return outcome.value

    def unless_failed(self, value: Operand) -> Operand:
        """Return the number, or NaN if anything failed before: the loop watches for NaN."""
        if self.failed is None:
            return value
        return self._unless(self.builder.get(self.failed), value)

    def _unless(self, fault: Operand, value: Operand) -> Operand:
        return self.builder.likely(self.builder.compute("not", fault), value, nan())


def entries(builder: Builder, value: Lowered) -> Sequence[Operand]:
    """The numbers that a wire holds."""
    if isinstance(value, Storage):
        assert value.length is not None
        return [builder.load(value, place) for place in range(value.length)]
    assert isinstance(value, Value) or value is not None
    return [value]
