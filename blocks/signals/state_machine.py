"""Finite state machine by a table: state[n+1] = following[4 state[n] + 2 second + first], or `initial` while reset.

Moore's: the outputs depend on the state alone, so that they change in the tick after the inputs.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class StateMachine(Block):
    """Sequence of states by two bits: modes of an instrument, a start-up, a self-test."""

    following: tuple[float, ...] = param(
        "1", "Next state, four for each state: for neither bit, the first, the second, both.",
        default=(0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0),
    )  # fmt: skip
    values: tuple[float, ...] = param("{unit}", "Output in each state.", default=(0.0, 1.0))
    initial: int = param("1", "State in tick 0, and while it is reset.", default=0, at_least=0, at_most=255)
    unit: str = param("", "Unit of the output.", default="1")

    first = Input("1", "First bit.", dtype=bool)
    second = Input("1", "Second bit.", dtype=bool, default=False)
    reset = Input("1", "Whether it goes to its initial state.", dtype=bool, default=False)

    table = Buffer("The next states.", int, ("following",))
    levels = Buffer("The values.", float, ("values",))


class State(NamedTuple):
    number: int


@StateMachine.requires
def requires(p: StateMachine) -> Iterator[tuple[str, str]]:
    states = len(p.values)
    if states > 256:
        yield "values", "at most 256 of them, one for each state"
    if len(p.following) != 4 * states:
        yield "following", f"{4 * states} of them, four for each of {states} states"
    if any(value != int(value) or not 0 <= value < states for value in p.following):
        yield "following", f"numbers of states, 0 to {states - 1}"
    if p.initial >= states:
        yield "initial", f"a state, at most {states - 1}"


@StateMachine.start
def start(p: StateMachine, table: list[int], levels: list[float]) -> State:
    table[:], levels[:] = map(int, p.following), p.values
    return State(p.initial)


@StateMachine.output("1")
def state(p: StateMachine, x: State) -> int:
    """Number of the state."""
    return x.number


@StateMachine.output("{unit}")
def value(p: StateMachine, x: State, levels: list[float]) -> float:
    """Output of the state."""
    return levels[x.number]


@StateMachine.update
def update(p: StateMachine, x: State, table: list[int], first: bool, second: bool, reset: bool) -> State:
    if reset:
        return State(p.initial)
    return State(table[4 * x.number + (2 if second else 0) + (1 if first else 0)])
