"""Parts to which limits of loops with many values in a period are known.

Where a small signal grows by much within a period and shrinks again, the growth over the whole
period hangs on the last digits of the maps of its ticks. Limits are known to where maps that are
half a last digit off agree on which side of them the loop is stable.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.rounded import moved_maps
from proofmass.runner.analysis.margins.bracketed import HIDDEN
from proofmass.runner.analysis.margins.figures import Figures

_STEPS = tuple(5.0 * 10.0**-digits for digits in range(6, 0, -1))  # parts of a limit, the first of which is not shown
_Factors = Callable[[npt.NDArray[Any]], npt.NDArray[Any]]


def known_parts(system: OpenLoop, limits: Figures) -> tuple[float, float, float]:
    """Return the parts of the lower and the upper limit of a loop, and of its turn, to which these are known.

    A part is 0 where all that is shown is known.
    """
    low, high, turn = limits.gain_reduction, limits.gain_margin, limits.phase_margin
    loops = [system, *(replace(system, map=moved) for moved in moved_maps(system.map))]
    return (
        _part(loops, lambda part: low / part) if low else 0.0,
        _part(loops, lambda part: high * part) if high else 0.0,
        _part(loops, lambda part: np.exp(-1j * turn * part)) if turn else 0.0,
    )


def _part(loops: Sequence[OpenLoop], factors: _Factors) -> float:
    """Return the least step from a limit within which all loops get unstable; 0 if it is the first."""
    for step in _STEPS:
        within, beyond = np.array([loop.growths(factors(np.array([1.0 - step, 1.0 + step]))) for loop in loops]).T
        if (within <= HIDDEN).all() and (beyond >= -HIDDEN).all():
            return step if step > _STEPS[0] else 0.0
    return 1.0


def limits_note(shown: float, every: float) -> list[str]:
    """Return a note on the parts to which the limits that are shown, and those of every stretch of a run, are known."""
    part = shown or every
    if part == 0.0:
        return []
    told = f"known to {100.0 * part:g} % only" if part < 1.0 else "not known"
    of = "" if shown else "of other stretches "
    return [f"limits {of}are {told}: what grows within the period and shrinks again is lost in rounding"]
