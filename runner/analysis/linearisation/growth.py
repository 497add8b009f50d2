"""Growth of closed loops: of one that starts up, and of one that is unstable where it stays."""

import numpy as np

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.poles import judged
from proofmass.runner.host.arrays import Complex

_MOVED = 1e-7  # part of itself by which a loop moves a pole of its own
_GROWS = 1e-9  # by which a pole may lie outside the unit circle before a loop counts as starting up


def starts_up(system: OpenLoop) -> bool:
    """Return whether a loop changes after its operating point, or surely grows away from it."""
    if system.map.starting or not len(_growing(system)):
        return system.map.starting
    verdict, _ = judged(np.real(system.closed()), not system.continuous, system.variation, system.ticks)
    return verdict == "unstable"


def makes_growth(system: OpenLoop) -> bool:
    """Return whether a loop makes growth itself, at a point where it stays: a pole it moves.

    Others are those of something else that begins there, such as an oscillator.
    """
    growing = _growing(system)
    apart = np.abs(growing[:, None] - system.open_poles[None, :]).min(axis=1, initial=np.inf)
    return not system.map.starting and bool((apart > _MOVED * np.abs(growing)).any())


def _growing(system: OpenLoop) -> Complex:
    poles = system.poles
    return poles[(poles.real if system.continuous else np.abs(poles) - 1.0) > _GROWS]
