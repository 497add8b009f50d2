"""Derivatives of an operating point by the parameters: a graph stands elsewhere with another spring.

Near the start they come from a run from tick 0 in dual numbers. An operating point x that comes back after a period has
those of the implicit function: x = F(x, p) gives dx/dp = (I - A)^-1 dF/dp.
"""

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Rings
from proofmass.runner.analysis.linearisation.seeds import PointSlopes
from proofmass.runner.derivatives.dual import PARAMETERS, slopes_of
from proofmass.runner.derivatives.dual_plan import differentiated
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError

MOST_TICKS = 20_000  # ticks of blocks that are run in dual numbers, at most
_AT_REST = 1e-6  # part of its size by which a state at rest may move in a period


def slopes_near_start(plan: Plan, blocks: set[str], tick: int, rings: Rings) -> PointSlopes | None:
    """Return the derivatives of what blocks hold in a tick, by a run from tick 0; None where that takes too long."""
    if tick * len(blocks) > MOST_TICKS:
        return None
    moved = differentiated(plan)
    try:
        engine = DualTicks(moved, start(moved), blocks, (), (), False, True)
        engine.advance(tick, ())
    except (TickError, ModelError):  # the bits of a number depend on parameters
        return None
    numbers = dict(rings.states_of(engine.memory(), blocks))
    moved_by = {entry: slopes_of(value, PARAMETERS) for entry, value in numbers.items()}
    return {entry: {str(name): float(slope) for name, slope in own.items()} for entry, own in moved_by.items() if own}


def slopes_at_rest(everything: PeriodMap) -> PointSlopes | None:
    """Return the derivatives of a point that comes back, from the map of all that moves; None of one that does not."""
    n = everything.order
    a, step = everything.parts()[0], everything.matrix[:n, -1]
    if np.any(np.abs(step) > _AT_REST * np.maximum(np.abs(np.array(everything.point)), 1e-300) + 1e-300):
        return None
    rest = Lasting(a).others
    inverse = rest @ np.linalg.inv(np.eye(n) - rest @ a)
    columns = {name: inverse @ slope[:n, -1] for name, slope in everything.slopes.items()}
    return {
        entry: {name: float(column[i]) for name, column in columns.items() if column[i]}
        for i, entry in enumerate(everything.states)
    }
