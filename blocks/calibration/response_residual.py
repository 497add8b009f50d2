"""Response residual: residual = sqrt(mean of (y - y_R)^2) over a period of N chips.

The iteration of a self-calibration ends when the error is below a threshold (Sarraf et al. 2012,
section 2.1, step vii). Controllers that look at few numbers settle on wrong parameters too, where
those numbers agree: all responses of a period do not. Of the right parameters the residual is the
noise of the readout.
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class ResponseResidual(Block):
    """Difference between a device and its reference model; one value per period, from the tick after its last chip."""

    chips: int = param("1", "Chips N of a period.", default=1023, at_least=1)
    unit: str = param("", "Unit of the responses.", default="V")

    measured = Input("{unit}", "Response y of the device.")
    modelled = Input("{unit}", "Response y_R of the reference model.")


class State(NamedTuple):
    chip: int
    squares: float
    finished: float


@ResponseResidual.output("{unit}", every="chips")
def residual(p: ResponseResidual, x: State) -> float:
    """Root mean square of the difference in the last whole period; zero in the first."""
    return x.finished


@ResponseResidual.update
def update(p: ResponseResidual, x: State, measured: float, modelled: float) -> State:
    squares = x.squares + (measured - modelled) * (measured - modelled)
    if x.chip < p.chips - 1:
        return State(x.chip + 1, squares, x.finished)
    return State(0, 0.0, math.sqrt(squares / float(p.chips)))
