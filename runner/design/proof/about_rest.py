"""Linear maps about a point of rest, or an orbit, that a proof encloses."""

import math
from dataclasses import dataclass, field

from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course, Onward
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan


@dataclass(frozen=True)
class AboutRest(Linearisation):
    """A plan about a memory at rest."""

    memory_there: Memory = field(kw_only=True)
    least: int = field(kw_only=True)  # base ticks after which it is there again

    def memory(self) -> Memory:
        """Return the memory there."""
        return self.memory_there.copy()

    def _onward(self, period: int) -> Onward:
        return Onward(self.course, self.memory_there)

    def _found(self, ends: Ends) -> OrbitPoint:
        return _rest_map(self.plan, ends, self.course, self.memory_there, self.least)


def _rest_map(plan: Plan, ends: Ends, course: Course, memory: Memory, least: int) -> OrbitPoint:
    """Return the map of a period between some ends about a memory that is there again after the `least` base ticks."""
    run = OrbitRun(plan, ends, course.onward(memory.tick))
    ticks = math.lcm(run.ticks, least)
    whole = ends.map(plan, memory=memory.copy(), span=ticks, rings=run.rings)
    return OrbitPoint(whole, 1, memory=memory, ticks=ticks, rings=run.rings)
