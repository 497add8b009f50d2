"""Relay with hysteresis: on where the input rises to `upper`, off where it falls to `lower`; continuous.

The instant of switching is found between ticks, to within the tolerance of the graph's
`[integration]`.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class Relay(Block):
    """Two-point controller of signals that move between ticks: a thermostat, a Schmitt trigger; at ticks Comparator."""

    lower: float = param("{input_unit}", "Input at which it switches off.", default=-0.5)
    upper: float = param("{input_unit}", "Input at which it switches on.", default=0.5)
    off: float = param("{output_unit}", "Output while it is off.", default=-1.0)
    on: float = param("{output_unit}", "Output while it is on.", default=1.0)
    initially_on: bool = param("", "Whether it is on at the start.", default=False)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to compare.")


class State(NamedTuple):
    is_on: bool
    switched: int
    switched_at: float


@Relay.requires
def requires(p: Relay) -> Iterator[tuple[str, str]]:
    if p.lower >= p.upper:
        yield "lower", f"less than upper = {p.upper:g}, or it would switch without end"


@Relay.start
def start(p: Relay) -> State:
    return State(p.initially_on, 0, 0.0)


@Relay.output("{output_unit}")
def output(p: Relay, x: State) -> float:
    """Output of the relay."""
    return p.on if x.is_on else p.off


@Relay.output("1")
def switchings(p: Relay, x: State) -> int:
    """Number of switchings so far."""
    return x.switched


@Relay.output("s")
def last_switching(p: Relay, x: State) -> float:
    """Time of the last switching."""
    return x.switched_at


def switch(p: Relay, x: State, time: float) -> State:
    return State(not x.is_on, x.switched + 1, time)


@Relay.event(then=switch)
def distance(p: Relay, x: State, input: float) -> float:
    return input - p.lower if x.is_on else p.upper - input
