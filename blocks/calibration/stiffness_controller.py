"""Stiffness controller: k += gain * sum of (y_R - y) over the chips of a window, once per period.

While the first chips hold the force constant a device that is stiffer than its reference model
answers less (Sarraf et al. 2012, section 2.1, steps ii and iii, Fig. 2c). The sum of error and a
priori value is the output.
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class StiffnessController(Block):
    """Integrates the static error between a device and its reference model into the stiffness of the model."""

    initial: float = param("N/m", "A priori stiffness.", default=49.5627, above=0.0)
    gain: float = param("N/m/V", "Stiffness per volt of summed error.", default=0.3592)
    every_chip: bool = param("", "Whether each chip of the window corrects, not their sum after it.", default=False)

    measured = Input("V", "Response y of the device.")
    modelled = Input("V", "Response y_R of the reference model.")
    window = Input("1", "Whether the chip belongs to the window.", dtype=bool)


class State(NamedTuple):
    correction: float
    error: float


def moved(p: StiffnessController, x: State, measured: float, modelled: float, window: bool) -> State:
    error = x.error + (modelled - measured) if window else x.error
    if window and not p.every_chip:
        return State(x.correction, error)
    return State(x.correction + p.gain * error, 0.0)


@StiffnessController.output("N/m")
def stiffness(p: StiffnessController, x: State, measured: float, modelled: float, window: bool) -> float:
    """Stiffness for the reference model, corrected in the same tick."""
    return p.initial + moved(p, x, measured, modelled, window).correction


@StiffnessController.update
def update(p: StiffnessController, x: State, measured: float, modelled: float, window: bool) -> State:
    return moved(p, x, measured, modelled, window)
