"""Table of two signals: bilinear between the four points about (x, y), values[i * columns + j] at (x_i, y_j).

The ends hold outside (Press et al., Numerical Recipes, section 3.6).
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.blocks.signals.look_up_table import interval


class SurfaceTable(Block):
    """Function of two signals by its values on a grid: a correction by input and temperature."""

    first_breakpoints: tuple[float, ...] = param("{first_unit}", "First inputs, ascending.", default=(-1.0, 1.0))
    second_breakpoints: tuple[float, ...] = param("{second_unit}", "Second inputs, ascending.", default=(-1.0, 1.0))
    values: tuple[float, ...] = param(
        "{output_unit}", "Outputs, row after row: one row for each first input.", default=(1.0, -1.0, -1.0, 1.0)
    )
    first_unit: str = param("", "Unit of the first input.", default="1")
    second_unit: str = param("", "Unit of the second input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    first = Input("{first_unit}", "First input.")
    second = Input("{second_unit}", "Second input.")

    firsts = Buffer("The first breakpoints.", float, ("first_breakpoints",))
    seconds = Buffer("The second breakpoints.", float, ("second_breakpoints",))
    levels = Buffer("The values.", float, ("values",))


@SurfaceTable.requires
def requires(p: SurfaceTable) -> Iterator[tuple[str, str]]:
    pairs = (("first_breakpoints", p.first_breakpoints), ("second_breakpoints", p.second_breakpoints))
    for name, knots in pairs:
        if len(knots) < 2 or any(after <= before for before, after in pairwise(knots)):
            yield name, "two or more, each above the one before"
    points = len(p.first_breakpoints) * len(p.second_breakpoints)
    if len(p.values) != points:
        yield "values", f"{points} of them, one for each pair of breakpoints"


@SurfaceTable.start
def start(p: SurfaceTable, firsts: list[float], seconds: list[float], levels: list[float]) -> None:
    firsts[:], seconds[:], levels[:] = p.first_breakpoints, p.second_breakpoints, p.values


def part(knots: Sequence[float], i: int, value: float) -> float:
    """Position of a value within its interval, from 0 to 1."""
    inside = (value - knots[i]) / (knots[i + 1] - knots[i])
    return 0.0 if inside < 0.0 else 1.0 if inside > 1.0 else inside


@SurfaceTable.output("{output_unit}")
def output(
    p: SurfaceTable, firsts: list[float], seconds: list[float], levels: list[float], first: float, second: float
) -> float:
    """The value of the table."""
    i, j, width = interval(firsts, first), interval(seconds, second), len(seconds)
    s, t = part(firsts, i, first), part(seconds, j, second)
    near = levels[i * width + j] + t * (levels[i * width + j + 1] - levels[i * width + j])
    far = levels[(i + 1) * width + j] + t * (levels[(i + 1) * width + j + 1] - levels[(i + 1) * width + j])
    return near + s * (far - near)
