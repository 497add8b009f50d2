"""Row of measurements in slots: settle, measure, and a tick to read; length of a slot = settling + averaging + T."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param

_COUNTED = "a slot is counted out in ticks: take a MeasurementSlots for each length, and switch between them"


class MeasurementSlots(Block):
    """Makes a row of averaged measurements while it is active, again and again; T is its period."""

    slots: int = param("1", "Measurements in a row.", default=2, at_least=1)
    settling: float = param("s", "Time to settle in a slot.", default=0.15, at_least=0.0, not_driven=_COUNTED)
    averaging: float = param(
        "s", "Time to measure in a slot; at least a tick.", default=0.05, above=0.0, not_driven=_COUNTED
    )

    active = Input("1", "Whether the row goes on; it begins anew when this becomes true.", dtype=bool, default=True)


class State(NamedTuple):
    slot: int
    tick: int


class Constants(NamedTuple):
    slots: int
    settled: int  # first tick of a slot to measure
    end: int  # its tick to read


@MeasurementSlots.constants
def constants(p: MeasurementSlots, period: float) -> Constants:
    settled = int(p.settling / period + 0.5)
    return Constants(p.slots, settled, settled + max(int(p.averaging / period + 0.5), 1))


@MeasurementSlots.output("1")
def slot(c: Constants, x: State) -> int:
    """Number of the slot, from 0."""
    return x.slot


@MeasurementSlots.output("1")
def measure(c: Constants, x: State, active: bool) -> bool:
    """True in the ticks that the average is taken over."""
    return active and c.settled <= x.tick < c.end


@MeasurementSlots.output("1")
def read(c: Constants, x: State, active: bool) -> bool:
    """True in the tick in which the average of the slot is ready."""
    return active and x.tick == c.end


@MeasurementSlots.output("1")
def finished(c: Constants, x: State, active: bool) -> bool:
    """True in the tick in which the average of the last slot is ready."""
    return active and x.tick == c.end and x.slot + 1 == c.slots


@MeasurementSlots.update
def update(c: Constants, x: State, active: bool) -> State:
    if not active:
        return State(0, 0)
    if x.tick < c.end:
        return State(x.slot, x.tick + 1)
    return State(x.slot + 1 if x.slot + 1 < c.slots else 0, 0)
