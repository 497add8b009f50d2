"""Two-position test: K1 = (N_up - N_down) / 2 g, bias K0 / K1 = (N_up + N_down) / 2 K1, from averages N at +g and -g.

The first two positions of the tumble test of an accelerometer (IEEE Std 1293, test procedures for
linear single-axis accelerometers). Calibration calls what a test gives before an adjustment "as
found", after it "as left".
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class TwoPositionComparison(Block):
    """Scale factor and bias with the axis up and down; the first test is kept as found, the latest as left."""

    gravity: float = param("m/s^2", "Local gravity.", default=9.80665, above=0.0)

    response = Input("1", "Averaged output.")
    up = Input("1", "Whether the axis is up.", dtype=bool)
    read = Input("1", "Whether the response is the result of a position; two positions are a test.", dtype=bool)


class State(NamedTuple):
    half: bool  # whether the first position of a test is read
    first: float  # half the response there, with the sign of the position
    mean: float  # half the response there
    found: bool
    scale_factor_found: float
    bias_found: float
    scale_factor_left: float
    bias_left: float


@TwoPositionComparison.output("s^2/m")
def scale_factor_found(p: TwoPositionComparison, x: State) -> float:
    """Scale factor K1 by the first test; zero before."""
    return x.scale_factor_found


@TwoPositionComparison.output("m/s^2")
def bias_found(p: TwoPositionComparison, x: State) -> float:
    """Bias by the first test; zero before."""
    return x.bias_found


@TwoPositionComparison.output("s^2/m")
def scale_factor_left(p: TwoPositionComparison, x: State) -> float:
    """Scale factor K1 by the latest test; zero before."""
    return x.scale_factor_left


@TwoPositionComparison.output("m/s^2")
def bias_left(p: TwoPositionComparison, x: State) -> float:
    """Bias by the latest test; zero before."""
    return x.bias_left


@TwoPositionComparison.update
def update(p: TwoPositionComparison, x: State, response: float, up: bool, read: bool) -> State:
    if not read:
        return x
    mean = 0.5 * response
    signed = mean if up else -mean
    k, b = x.scale_factor_found, x.bias_found
    if not x.half:
        return State(True, signed, mean, x.found, k, b, x.scale_factor_left, x.bias_left)
    scale = (x.first + signed) / p.gravity
    bias = (x.mean + mean) / scale if scale != 0.0 else 0.0
    return State(False, 0.0, 0.0, True, k if x.found else scale, b if x.found else bias, scale, bias)
