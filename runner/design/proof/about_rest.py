"""Linear maps about a point of rest, or an orbit, that a proof encloses."""

import math
from dataclasses import dataclass, field

from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Onward
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.plan.memory import Memory


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
        """Return the map of a period between some ends, after which the memory is there again."""
        run = OrbitRun(self.plan, ends, self.course.onward(self.memory_there.tick))
        ticks = math.lcm(run.ticks, self.least)
        whole = ends.map(self.plan, memory=self.memory(), span=ticks, rings=run.rings)
        return OrbitPoint(whole, 1, memory=self.memory_there, ticks=ticks, rings=run.rings)
