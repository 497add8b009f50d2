"""Correlation cells: sums[k] += +y or -y as the chip k samples ago was a one or a zero, over a period of chips.

For a maximal-length sequence of N chips and a response h in its steady state, sums[k] = (N+1)
h[k] - sum of h (Sarraf et al. 2012, section 2.1, Fig. 2d, eq. 2 and 3).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param

LARGEST = 1 << 40  # code; periods of 2^22 chips do not leave 64 bits


class Correlator(Block):
    """Bank of correlation cells; one vector of sums per period, available from the tick after its last chip."""

    cells: int = param("1", "Number of lags, from 0.", default=16, at_least=1, at_most=4096)
    chips: int = param("1", "Chips of a period.", default=1023, at_least=1, at_most=1 << 22)

    bit = Input("1", "Chip that excites the device.", dtype=bool)
    code = Input("1", "Response of the device in the same tick; clipped at 2^40.", dtype=int)

    history = Buffer("Last chips, newest first: 0 for a one, -1 for a zero; y ^ -1 less -1 is -y.", int, ("cells",))
    sums = Buffer("Sums of the period under way.", int, ("cells",))
    finished = Buffer("Sums of the last whole period.", int, ("cells",))


class State(NamedTuple):
    chip: int
    filled: int


@Correlator.output("1", shape=("cells",), dtype=int, every="chips")
def impulse_response(c: Correlator, finished: list[int], out: list[int]) -> None:
    """Sums of the last whole period, by lag: impulse response times chips + 1, less a constant."""
    for k in range(len(finished)):
        out[k] = finished[k]


@Correlator.update
def update(
    c: Correlator, x: State, history: list[int], sums: list[int], finished: list[int], bit: bool, code: int
) -> State:
    code = min(max(code, -LARGEST), LARGEST)
    chip_of_cell = 0 if bit else -1
    for k in range(len(sums)):
        older = history[k]
        history[k] = chip_of_cell
        sums[k] += (code ^ chip_of_cell) - chip_of_cell
        chip_of_cell = older
    if x.filled < len(sums):  # of cells without a chip yet
        for k in range(len(sums)):
            if k > x.filled:
                sums[k] = 0
    chip = x.chip + 1
    if chip == c.chips:
        chip = 0
        for k in range(len(sums)):
            finished[k] = sums[k]
            sums[k] = 0
    return State(chip, x.filled + 1 if x.filled < len(sums) else x.filled)
