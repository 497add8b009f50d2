"""Functions of a group at one instant, in plain Python: derivatives, clearances of events, states after an event."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, assert_never

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.checks.schedule import ConstantsOf, OutputStep, Schedule, outputs_of
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.continuous.algebraic import solve_in_place
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
    bindings,
)
from proofmass.runner.plan.constants import constants_of, in_python
from proofmass.runner.plan.groups import Group, state_fields


class StageContext(NamedTuple):
    """Values that are fixed during a tick: constants by block, inputs at its start and their
    slopes, guesses for the tears of loops."""

    constants: Mapping[str, Any]
    inputs: Sequence[float]
    slopes: Sequence[float]  # of the inputs that move, in order
    guesses: Sequence[float]
    start: float


class _Call(NamedTuple):
    """A function, the places of its arguments among the values of an instant, and the place of its result."""

    at: str  # block and function, for messages
    function: Callable[..., Any]
    arguments: tuple[int, ...]
    result: int


class Stages:
    """A group's functions of (context, time, states), states being a flat sequence of floats."""

    _solve_loop = staticmethod(solve_in_place)  # of an instant; whether solved

    def __init__(
        self, blocks: Mapping[str, Block], schedule: Schedule, group: Group, periods: Callable[[str], float]
    ) -> None:
        self.blocks, self.schedule, self.group, self.periods = blocks, schedule, group, periods
        self.at = ""  # the function under way
        self.unsolved = ""  # wire of a loop that had no solution
        self.watching, self.lost = False, ""  # the first output that declared that it had no value
        ends = ((name, port) for name, port in outputs_of(group.nodes) if type(blocks[name]).outputs[port].no_value)
        self._ends = frozenset(f"{name}.{port}" for name, port in ends)
        self._states: list[tuple[str, Any, list[type]]] = [
            (name, type(blocks[name]).state_class(), [kind for _, kind in state_fields(blocks[name])])
            for name in group.blocks
        ]
        self._places: dict[Binding | ConstantsOf, int] = {Time(): 0}  # of the values of an instant
        self._defaults: dict[int, float] = {}  # of inputs that are not connected, by place
        self._nodes = [self._node(node) for node in group.nodes]
        self._of_place = {call.result: call for call in self._nodes}
        self._torn = {  # tears and others of the loop, for the place of each tear
            self._place(WireBinding(tear)): (self._wires(loop.tears), self._wires(loop.others))
            for loop in group.loops
            for tear in loop.tears
        }
        derivatives = ((name, type(blocks[name]).functions.get("derivative")) for name in group.blocks)
        self._rates = [None if rates is None else self._call(name, "derivative", rates) for name, rates in derivatives]
        self._clearances = [
            self._call(name, event, type(blocks[name]).events[event][0]) for name, event in group.events
        ]
        self._clearances += [
            self._call(name, corner, type(blocks[name]).corners[corner]) for name, corner in group.corners
        ]
        self._thens = [self._call(name, event, type(blocks[name]).events[event][1]) for name, event in group.events]
        self._members = [(name, self._place(ConstantsOf(name))) for name in group.members]
        self._held = [self._place(StateBinding(name)) for name in group.blocks]
        self._inputs, self._guesses = self._wires(group.inputs), self._wires(group.guesses)
        self._ramps = [(self._place(WireBinding(node)), group.inputs.index(node)) for node in group.ramps]

    def rates(self, context: StageContext, time: float, x: Sequence[float], out: Any) -> None:
        """Derivatives of all states; modes stand still."""
        known = self._known(context, time, x)
        place = 0
        for (_, _, kinds), call in zip(self._states, self._rates, strict=True):
            made = kinds if call is None else self._called(call, known)
            for kind, rate in zip(kinds, made, strict=True):
                out[place] = 0.0 if call is None or kind is not float else rate
                place += 1

    def clearances(self, context: StageContext, time: float, x: Sequence[float], out: Any) -> None:
        """For each event a number that is above zero until it happens; then the side of each corner, or a count."""
        known = self._known(context, time, x)
        for number, call in enumerate(self._clearances):
            out[number] = float(self._called(call, known))

    def then(self, context: StageContext, time: float, x: Any, which: int) -> None:
        """The states after an event."""
        made = self._called(self._thens[which], self._known(context, time, x))
        name = self.group.events[which][0]
        for value, (field, kind) in zip(made, state_fields(self.blocks[name]), strict=True):
            x[self.group.states.index((name, field))] = float(kind(value))

    def states(self, x: Sequence[float]) -> dict[str, Any]:
        """States of all blocks, of the types that they declare."""
        states, place = {}, 0
        for name, state, kinds in self._states:
            states[name] = state(*[kind(v) for kind, v in zip(kinds, x[place : place + len(kinds)], strict=True)])
            place += len(kinds)
        return states

    def _known(self, context: StageContext, time: float, x: Sequence[float]) -> list[Any]:
        """Arguments of all functions of the blocks at an instant, each in its place."""
        values: list[Any] = [None] * len(self._places)
        values[0] = time
        for name, place in self._members:
            values[place] = context.constants[name]
        for place, state in zip(self._held, self.states(x).values(), strict=True):
            values[place] = state
        for place, value in zip(self._inputs, context.inputs, strict=True):
            values[place] = value
        for (place, number), slope in zip(self._ramps, context.slopes, strict=True):
            values[place] = context.inputs[number] + slope * (time - context.start)
        for place, value in zip(self._guesses, context.guesses, strict=True):
            values[place] = value
        for place, default in self._defaults.items():
            values[place] = default
        for call in self._nodes:
            if call.result not in self._torn:
                values[call.result] = self._called(call, values)
            elif call.result == self._torn[call.result][0][0]:
                self._solve(call, values)
        return values

    def _solve(self, first: _Call, known: list[Any]) -> None:
        """Solve the loop that has this first tear."""
        loop = self._torn[first.result]
        if not self._solve_loop(*loop, known, lambda place: self._called(self._of_place[place], known)):
            self.unsolved = first.at

    def _called(self, call: _Call, known: list[Any]) -> Any:
        self.at = call.at
        value = call.function(*[known[place] for place in call.arguments])
        if self.watching and not self.lost and call.at in self._ends and math.isnan(value):
            self.lost = call.at
        return value

    def _node(self, node: OutputStep) -> _Call:
        return self._constants(node.block) if isinstance(node, ConstantsOf) else self._output(*node)

    def _output(self, name: str, port: str) -> _Call:
        call = self._call(name, port, type(self.blocks[name]).output_functions[port])
        return call._replace(result=self._place(WireBinding((name, port))))

    def _constants(self, name: str) -> _Call:
        """Compute the constants of a block from the signals that drive its parameters."""
        drivers = self.schedule.drivers
        driven = [p for p in type(self.blocks[name]).parameters if (name, p) in drivers]

        def compute(*values: Any) -> Any:
            return self._constants_of(name, dict(zip(driven, values, strict=True)))

        places = tuple(self._wires(drivers[name, p] for p in driven))
        return _Call(f"{name}.constants", compute, places, self._place(ConstantsOf(name)))

    def _constants_of(self, name: str, moved: Mapping[str, Any]) -> Any:
        """Constants of a block some of whose parameters have changed."""
        block = self.blocks[name]
        made = type(block).parameters_class()
        fields: Any = made._fields  # type: ignore[attr-defined]
        return constants_of(block, made(*(moved.get(p, getattr(block, p)) for p in fields)), self.periods(name))

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        """Return the callable for a function of a block."""
        return in_python(block, behaviour)

    def _call(self, name: str, what: str, behaviour: Behaviour) -> _Call:
        block = self.blocks[name]
        given = bindings(self.schedule, block, name, what, behaviour)
        arguments = [self._place(ConstantsOf(name)), *map(self._argument, given)]
        return _Call(f"{name}.{what}", self._callable(block, behaviour), tuple(arguments), -1)

    def _argument(self, binding: Binding) -> int:
        """Place of an argument among the values of an instant."""
        place = self._place(binding)
        match binding:
            case Default(_, value):
                self._defaults[place] = value
            case Time() | StateBinding() | WireBinding():
                pass
            case Parameters() | Out() | Tick() | Deviate() | BufferBinding():
                raise ValueError(f"{binding} is not known between ticks")
            case _:
                assert_never(binding)
        return place

    def _wires(self, nodes: Iterable[Endpoint]) -> list[int]:
        return [self._place(WireBinding(node)) for node in nodes]

    def _place(self, key: Binding | ConstantsOf) -> int:
        return self._places.setdefault(key, len(self._places))
