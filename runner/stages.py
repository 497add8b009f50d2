"""The functions of a group at one instant, in plain Python: derivatives, clearances of events, what follows them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from proofmass.blocks.declare import Block
from proofmass.graphs.schedule import Node, Schedule
from proofmass.runner.constants import constants_of
from proofmass.runner.groups import Group, state_fields


class Context(NamedTuple):
    """What is fixed during a tick: constants by block, inputs as they are at its start and how fast they move."""

    constants: Mapping[str, Any]
    inputs: Sequence[float]
    slopes: Sequence[float]  # of the inputs that move, one after the other
    start: float


class Stages:
    """A group's functions of (context, time, states), states being a flat sequence of floats."""

    def __init__(
        self, blocks: Mapping[str, Block], schedule: Schedule, group: Group, periods: Callable[[str], float]
    ) -> None:
        self.blocks, self.schedule, self.group, self.periods = blocks, schedule, group, periods
        self.at = ""  # the function under way, for messages

    def rates(self, context: Context, time: float, x: Sequence[float], out: Any) -> None:
        """Derivatives of all states; modes stand still."""
        known = self._known(context, time, x)
        place = 0
        for name in self.group.blocks:
            block = self.blocks[name]
            derivative = block.functions.get("derivative")
            made = self._called(known, name, "derivative", derivative) if derivative else None
            for number, (_, kind) in enumerate(state_fields(block)):
                out[place] = made[number] if kind is float and made is not None else 0.0
                place += 1

    def clearances(self, context: Context, time: float, x: Sequence[float], out: Any) -> None:
        """What is above zero as long as nothing happens, for each event."""
        known = self._known(context, time, x)
        for number, (name, event) in enumerate(self.group.events):
            out[number] = self._called(known, name, event, self.blocks[name].events[event][0])

    def then(self, context: Context, time: float, x: Any, which: int) -> None:
        """The states after an event."""
        known = self._known(context, time, x)
        name, event = self.group.events[which]
        made = self._called(known, name, event, self.blocks[name].events[event][1])
        for number, (_, kind) in enumerate(state_fields(self.blocks[name])):
            x[self.group.states.index((name, made._fields[number]))] = float(kind(made[number]))

    def states(self, x: Sequence[float]) -> dict[str, Any]:
        """The states of all blocks as they declare them."""
        made, place = {}, 0
        for name in self.group.blocks:
            fields = state_fields(self.blocks[name])
            state: Any = self.blocks[name].state_class()
            values = x[place : place + len(fields)]
            made[name] = state(*(kind(value) for (_, kind), value in zip(fields, values, strict=True)))
            place += len(fields)
        return made

    def _known(self, context: Context, time: float, x: Sequence[float]) -> "_Known":
        """Everything that the functions of the blocks are given at an instant."""
        constants = dict(context.constants)
        signals = dict(zip(self.group.inputs, context.inputs, strict=True))
        for node, slope in zip(self.group.ramps, context.slopes, strict=True):
            signals[node] = signals[node] + slope * (time - context.start)
        known = _Known(constants, self.states(x), signals, time)
        for name, port in self.group.nodes:
            block = self.blocks[name]
            if port:
                signals[name, port] = self._called(known, name, port, block.output_functions[port])
            else:
                self.at = f"{name}.constants"
                made = block.parameters_class()
                drivers = self.schedule.drivers
                values = (
                    signals[drivers[name, p]] if (name, p) in drivers else getattr(block, p)
                    for p in made._fields  # type: ignore[attr-defined]
                )
                constants[name] = constants_of(block, made(*values), self.periods(name))
        return known

    def _called(self, known: "_Known", name: str, what: str, behaviour: Any) -> Any:
        self.at = f"{name}.{what}"
        arguments = (self._argument(known, name, argument) for argument in behaviour.arguments)
        return behaviour.function(known.constants[name], *arguments)

    def _argument(self, known: "_Known", name: str, argument: str) -> Any:
        if argument == "x":
            return known.states[name]
        if argument == "time":
            return known.time
        driver: Node | None = self.schedule.drivers.get((name, argument))
        return self.blocks[name].inputs[argument].default if driver is None else known.signals[driver]


class _Known(NamedTuple):
    constants: dict[str, Any]
    states: dict[str, Any]
    signals: dict[Node, float]
    time: float
