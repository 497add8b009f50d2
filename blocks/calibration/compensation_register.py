"""Compensation register: value' = value / (1 + deviation) when loaded (digital quartz accelerometer, eq. 22 and 30).

The gain k(D(z)) of the controller is corrected by the deviation of the forward gain, N_VREF of the
converter that makes the reference by that of the feedback gain.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import saturated
from proofmass.blocks.declaration.declare import Block, Input, param


class CompensationRegister(Block):
    """Number that makes up for the drift of a gain; each load corrects what is left."""

    initial: float = param("1", "Value before any compensation.", default=1.0)
    limit: float = param("1", "Largest deviation from the initial value, relative.", default=0.01, above=0.0, below=1.0)

    deviation = Input("1", "Relative deviation of the gain.")
    load = Input("1", "Whether to correct for it.", dtype=bool)


class State(NamedTuple):
    factor: float


@CompensationRegister.start
def start(p: CompensationRegister) -> State:
    return State(1.0)


@CompensationRegister.output("1")
def value(p: CompensationRegister, x: State) -> float:
    """The compensating number."""
    return p.initial * x.factor


@CompensationRegister.update
def update(p: CompensationRegister, x: State, deviation: float, load: bool) -> State:
    if not load:
        return x
    return State(saturated(x.factor / (1.0 + saturated(deviation, -p.limit, p.limit)), 1.0 - p.limit, 1.0 + p.limit))
