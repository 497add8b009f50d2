"""Instants of edges in time: one that is meant to be at a tick is there, and no other is moved."""

from proofmass.blocks.arithmetic.rounding import nearest_integer

ON_TICK = 1e-6  # of a tick: a time that was typed so near is meant to be the tick
LATE = 1.0 + 2e-15  # of a time: more than what rounding takes off a tick


def instant(time: float, period: float) -> float:
    """Return the time of a tick for a time written as hardly later, else the time itself."""
    late = time - nearest_integer(time / period) * period
    return time - late if 0.0 < late <= ON_TICK * period else time
