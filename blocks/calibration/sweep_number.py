"""Swept number: number = first + slot increment while active, else the working number.

(Digital quartz accelerometer, eq. 17.)
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class SweepNumber(Block):
    """Number that a sweep of the modulation goes through, N_FPGA."""

    first: float = param("1", "First number of a sweep.", default=4000.0)
    increment: float = param("1", "From one slot of the sweep to the next.", default=1000.0)
    working: float = param("1", "Number outside sweeps.", default=34952.0)

    slot = Input("1", "Slot of the sweep, from 0.", dtype=int)
    active = Input("1", "Whether a sweep is under way.", dtype=bool, default=True)


@SweepNumber.output("1")
def number(p: SweepNumber, slot: int, active: bool) -> float:
    """The number."""
    return p.first + p.increment * float(slot) if active else p.working
