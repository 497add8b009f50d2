"""Operating points that a run leaves: small signals find another graph at its end.

A map that hardly changes from one period to the next counts as that of the graph, however far it
gets in time. So a map that moves on at all is compared with that of the last whole period of the
graph's own run. So is that of a graph without loops which settles after its run.
"""

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.digraph import loops
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Onward
from proofmass.runner.analysis.linearisation.map_changes import effect
from proofmass.runner.analysis.linearisation.orbit import FROZEN, OrbitPoint, axis
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.plan.planned import Plan

LONGEST = 1 << 20  # base ticks of a run, up to which its end is looked at


def is_left(plan: Plan, ends: Ends, point: OrbitPoint, onward: Onward) -> bool:
    """Return whether the map between some wires is another at the end of the graph's own run.

    An orbit that closes is not left: it was found to come back.
    """
    if point.periods > 1:
        return False
    try:
        run, last = OrbitRun(plan, ends, onward), plan.ticks()
        periods = (last - run.first) // run.ticks - 1
        if last > LONGEST:
            return False
        if periods > 0:
            return bool(point.later) and effect(point.map, run.map(periods), axis()) > FROZEN
        if last > run.first or any(loops(plan.readers)):
            return False
        end = onward.course.onward(max(last // run.ticks - 1, 0) * run.ticks)  # it settles later
        return effect(point.map, OrbitRun(plan, ends, end).map(0), axis()) > FROZEN
    except ModelError:  # there is no end, or there is no map there
        return False
