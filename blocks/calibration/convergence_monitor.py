"""Convergence monitor: done = largest relative change of stiffness and damping < tolerance, `hold` ticks in a row.

The iteration repeats until the error falls below a threshold (Sarraf et al. 2012, section 2.1, step
vii).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class ConvergenceMonitor(Block):
    """Tells when a calibration has settled, and how long it took; runs once a period."""

    tolerance: float = param("1", "Relative change from one period to the next.", default=1e-3, above=0.0)
    hold: int = param("1", "Periods in a row with less change than that.", default=3, at_least=1)

    stiffness = Input("N/m", "Stiffness of the reference model.")
    damping = Input("kg/s", "Damping of the reference model.")


class State(NamedTuple):
    stiffness: float
    damping: float
    seen: int
    quiet: int


@ConvergenceMonitor.output("1")
def done(p: ConvergenceMonitor, x: State) -> bool:
    """True from the period on in which the parameters have settled."""
    return x.quiet >= p.hold


@ConvergenceMonitor.output("1")
def periods(p: ConvergenceMonitor, x: State) -> int:
    """Periods until they had settled, or so far."""
    return x.seen


@ConvergenceMonitor.update
def update(p: ConvergenceMonitor, x: State, stiffness: float, damping: float) -> State:
    if x.quiet >= p.hold:
        return x
    settled = (
        x.seen > 0
        and abs(stiffness - x.stiffness) < p.tolerance * abs(stiffness)
        and abs(damping - x.damping) < p.tolerance * abs(damping)
    )
    return State(stiffness, damping, x.seen + 1, x.quiet + 1 if settled else 0)
