"""Loops that are open but for instants: calibrations that count ticks, take a mean, and then set a parameter.

From instant to instant a counter goes on by the same step. Where it does not, the loop may be closed for a tick.
"""

from collections.abc import Collection

import numpy as np

from proofmass.runner.plan.keys import StateField
from proofmass.runner.targets.native import CompiledLoop

LONGEST = 40_000  # base ticks in which two instants are looked for
_OFTEN = 0.125  # part of the ticks: what jumps more often, as a shift register, does not count


def jumps(run: CompiledLoop, blocks: Collection[str]) -> list[int]:
    """Return the ticks from now on in which a whole number in the states of some blocks does not count on as before."""
    counters = [
        key for key, kind in run.kinds() if isinstance(key, StateField) and kind is not float and key.block in blocks
    ]
    if not counters:
        return []
    steps = np.diff(run.numbers(counters, run.tick + LONGEST), axis=0)
    jumped = steps[1:] != steps[:-1]
    rare = jumped.mean(axis=0) <= _OFTEN
    return (1 + np.flatnonzero(jumped[:, rare].any(axis=1))).tolist()
