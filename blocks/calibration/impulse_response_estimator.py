"""Impulse response by correlation: h[k] = (sum of b[n-k] y[n] - R) / (N + 1) over a period of N chips b = +1 or -1.

A maximal-length sequence has the autocorrelation N at 0 and -1 elsewhere: in the steady state the
sums are (N + 1) h[k] - sum of h (Sarraf et al. 2012, section 2.1, Fig. 2d, eq. 2 and 3). That
constant, and what an offset of y adds to every sum, is R: the mean sum of the last `tail` cells,
where the response has died out, or 0 without a tail.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class ImpulseResponseEstimator(Block):
    """Correlation cells for a response that is a number; one vector per period, from the tick after its last chip."""

    cells: int = param("1", "Number of lags, from 0.", default=16, at_least=1, at_most=4096)
    chips: int = param("1", "Chips N of a period.", default=1023, at_least=1)
    tail: int = param("1", "Last cells whose mean is taken off all; 0 leaves the constant in.", default=0, at_least=0)
    unit: str = param("", "Unit of the response.", default="V")

    bit = Input("1", "Chip that excites the device.", dtype=bool)
    response = Input("{unit}", "Response of the device in the same tick.")

    history = Buffer("Last chips, newest first: +1, -1, or 0 before the start.", float, ("cells",))
    sums = Buffer("Sums of the period under way.", float, ("cells",))
    finished = Buffer("Response of the last whole period.", float, ("cells",))


class State(NamedTuple):
    chip: int


@ImpulseResponseEstimator.requires
def requires(p: ImpulseResponseEstimator) -> Iterator[tuple[str, str]]:
    if p.tail >= p.cells:
        yield "tail", f"less than cells = {p.cells}"


@ImpulseResponseEstimator.output("{unit}", shape=("cells",), dtype=float, every="chips")
def impulse_response(c: ImpulseResponseEstimator, finished: list[float], out: list[float]) -> None:
    """Response to one chip, per chip after it; zeros in the first period."""
    for k in range(len(finished)):
        out[k] = finished[k]


@ImpulseResponseEstimator.update
def update(
    c: ImpulseResponseEstimator,
    x: State,
    history: list[float],
    sums: list[float],
    finished: list[float],
    bit: bool,
    response: float,
) -> State:
    chip_of_cell = 1.0 if bit else -1.0
    for k in range(len(sums)):
        older = history[k]
        history[k] = chip_of_cell
        sums[k] += chip_of_cell * response
        chip_of_cell = older
    chip = x.chip + 1
    if chip < c.chips:
        return State(chip)
    constant = 0.0
    for k in range(len(sums) - c.tail, len(sums)):
        constant += sums[k] / float(c.tail)
    for k in range(len(sums)):
        finished[k] = (sums[k] - constant) / float(c.chips + 1)
        sums[k] = 0.0
    return State(0)
