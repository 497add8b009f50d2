"""Counter modulo n: count[n+1] = 0 if reset, else (count[n] + 1) mod modulus if enabled, else count[n]."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class Counter(Block):
    """Counts the ticks in which it is enabled; an EdgeDetector before it counts edges."""

    modulus: int = param("1", "Counts from 0 to one less.", default=256, at_least=1, at_most=1 << 48)

    enable = Input("1", "Whether the tick counts.", dtype=bool, default=True)
    reset = Input("1", "Whether it starts again from 0.", dtype=bool, default=False)


class State(NamedTuple):
    counted: int


@Counter.output("1")
def count(p: Counter, x: State) -> int:
    """The ticks counted before this one, modulo the modulus."""
    return x.counted


@Counter.output("1")
def carry(p: Counter, x: State, enable: bool) -> bool:
    """True in the tick that takes the highest count to 0: the clock of a further counter."""
    return enable and x.counted == p.modulus - 1


@Counter.update
def update(p: Counter, x: State, enable: bool, reset: bool) -> State:
    following = 0 if x.counted == p.modulus - 1 else x.counted + 1
    return State(0 if reset else following if enable else x.counted)
