"""Linear maps about a point of rest, or an orbit, that a proof encloses."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Onward
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.plan.memory import Memory


@dataclass(frozen=True)
class AboutRest(Linearisation):
    """A plan about a memory at rest."""

    memory_there: Memory = field(kw_only=True)
    least: int = field(kw_only=True)  # base ticks after which it is there again
    along: Mapping[Entry, Mapping[Entry, float]] = field(default_factory=dict, kw_only=True)  # by each of its places

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
        whole = _put_back(whole, self.along)
        return OrbitPoint(whole, 1, memory=self.memory_there, ticks=ticks, rings=run.rings)


def _put_back(of: PeriodMap, along: Mapping[Entry, Mapping[Entry, float]]) -> PeriodMap:
    """Return a map after which all that is remembered is moved back along its curves to where places were."""
    matrix = of.matrix.copy()
    for place, own in along.items():
        if place not in of.states:  # it moves nothing that is there
            continue
        passed = of.matrix[of.states.index(place)]
        for i, entry in enumerate(of.states):
            matrix[i] -= own.get(entry, 0.0) * passed
    kept = [i for i, entry in enumerate(of.states) if entry not in along]
    return replace(of, matrix=matrix, ticks=None).kept(kept) if along else of
