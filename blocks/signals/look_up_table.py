"""Look-up table: output = v_i + (v_(i+1) - v_i) (input - b_i) / (b_(i+1) - b_i) between breakpoints b_i and b_(i+1)."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class LookUpTable(Block):
    """Function of one signal by its values at breakpoints, with straight lines between: a calibration curve."""

    breakpoints: tuple[float, ...] = param("{input_unit}", "Inputs, ascending.", default=(-1.0, 0.0, 1.0))
    values: tuple[float, ...] = param("{output_unit}", "Output at each breakpoint.", default=(-1.0, 0.0, 1.0))
    extrapolated: bool = param("", "Whether the lines at the ends go on; else the end values hold.", default=False)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Number to look up.")

    knots = Buffer("The breakpoints.", float, ("breakpoints",))
    levels = Buffer("The values.", float, ("values",))


@LookUpTable.requires
def requires(p: LookUpTable) -> Iterator[tuple[str, str]]:
    if len(p.breakpoints) < 2 or any(after <= before for before, after in pairwise(p.breakpoints)):
        yield "breakpoints", "two or more, each above the one before"
    if len(p.values) != len(p.breakpoints):
        yield "values", f"{len(p.breakpoints)} of them, as many as breakpoints"


@LookUpTable.start
def start(p: LookUpTable, knots: list[float], levels: list[float]) -> None:
    for i in range(len(p.breakpoints)):
        knots[i] = p.breakpoints[i]
        levels[i] = p.values[i]


def interval(knots: Sequence[float], input: float) -> int:
    """Index of the breakpoint at which the interval of the input begins, found by halving."""
    low, high = 0, len(knots) - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if knots[middle] <= input else (low, middle)
    return low


@LookUpTable.output("{output_unit}")
def output(p: LookUpTable, knots: list[float], levels: list[float], input: float) -> float:
    """The value of the table at the input."""
    i = interval(knots, input)
    part = (input - knots[i]) / (knots[i + 1] - knots[i])
    if not p.extrapolated:
        part = 0.0 if part < 0.0 else 1.0 if part > 1.0 else part
    return levels[i] + part * (levels[i + 1] - levels[i])
