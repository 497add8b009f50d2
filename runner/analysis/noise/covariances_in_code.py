"""Ticks in machine code that move covariances on: what `CovarianceTicks` does."""

from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.noise.covariances import Covariances, GroupSlopes
from proofmass.runner.derivatives.dual_noise import Followed
from proofmass.runner.plan.memory import Memory, Rows
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.events import WIRE
from proofmass.runner.targets.native_noise import NoiseInCode, TicksDone
from proofmass.runner.targets.native_slopes import SlopeCode

_EVERY = 64  # ticks that are composed at a time


class CovarianceInCode(NoiseInCode):
    """Ticks from a memory without noise on."""

    def __init__(self, code: SlopeCode, plan: Plan, memory: Memory, followed: Followed, found: Covariances) -> None:
        super().__init__(code, plan, memory, followed, set())
        self._covariances = found

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `UndefinedSlopesError`."""
        sound = super().advance(last, rows)
        if sound:
            done = self.done()
            for first in range(0, done.number, _EVERY):
                self._covariances.moved(*self._moves(done, range(first, min(first + _EVERY, done.number))))
        return sound

    def _moves(self, done: TicksDone, ticks: range) -> tuple[dict[Endpoint, list[float]], GroupSlopes]:
        """Return the values of outputs in some ticks, and the slopes of these and of what lasts after them."""
        events = done.events.of_rows(ticks.start * done.most, ticks.stop * done.most)
        heard = {
            node: events.source == number for number, node in enumerate(self.wire_nodes) if node in self._of.outputs
        }
        heard = {node: (events.kind == WIRE) & heard[node] for node in self._of.outputs}
        asked = [row for of in heard.values() for row in events.row[of].tolist()]
        columns, owners, deviations = dict[int, int](), dict[str, list[int]](), list[float]()
        entering = events.entered & (events.kind != WIRE)
        of_events = (events.row, events.kind, events.source, events.drop, events.like, events.part)
        for row, kind, source, drop, like, part in zip(*(each[entering].tolist() for each in of_events), strict=True):
            if like == row:
                columns[row] = len(deviations)
                owners.setdefault(self.block_names[source], []).append(columns[row])
                place = self.block_names[source], self.part(kind, part)
                deviations.append(self._covariances.deviation(place, Drop.of_code(int(drop)) if drop else None))
            columns[row] = columns[like]
        lasting, fresh = done.back(ticks, asked, columns, range(done.size))
        order = [*range(done.size, done.size + len(asked)), *range(done.size)]  # outputs first
        slopes = GroupSlopes(lasting.T[order], (fresh.T * deviations)[order], owners, len(asked))
        return {node: events.value[of].tolist() for node, of in heard.items()}, slopes
