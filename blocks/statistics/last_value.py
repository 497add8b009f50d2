"""Last value: the input of the last tick before `until`, kept from then on."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class LastValue(Block):
    """The last sample before a tick; zero until there is one."""

    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to keep.")


class State(NamedTuple):
    value: float


@LastValue.output("{unit}")
def value(p: LastValue, x: State) -> float:
    """The sample."""
    return x.value


@LastValue.update
def update(p: LastValue, x: State, tick: int, input: float) -> State:
    return x if 0 < p.until <= tick else State(1.0 * input)  # measures read codes and bits too
