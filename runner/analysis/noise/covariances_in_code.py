"""Ticks in machine code that move covariances on: what `CovarianceTicks` does."""

import math

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.noise.covariances import Covariances, GroupSlopes
from proofmass.runner.analysis.noise.noise_map import variance
from proofmass.runner.derivatives.dual_noise import Followed
from proofmass.runner.plan.memory import Memory, Rows
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.events import WIRE
from proofmass.runner.targets.native_noise import NoiseInCode, TickGroup
from proofmass.runner.targets.native_slopes import SlopeCode


class CovarianceInCode(NoiseInCode):
    """Ticks from a memory without noise on."""

    def __init__(self, code: SlopeCode, plan: Plan, memory: Memory, followed: Followed, found: Covariances) -> None:
        super().__init__(code, plan, memory, followed, set())
        self._covariances = found

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `UndefinedSlopesError`."""
        sound = super().advance(last, rows)
        for group in self.groups() if sound else ():
            self._covariances.moved(*self._moves(group))
        return sound

    def _moves(self, group: TickGroup) -> tuple[dict[Endpoint, list[float]], GroupSlopes]:
        """Return the values of outputs in some ticks, and the slopes of these and of what lasts after them."""
        recorded: dict[Endpoint, list[float]] = {node: [] for node in self._of.outputs}
        rows: dict[Endpoint, list[int]] = {node: [] for node in self._of.outputs}
        columns, owners = dict[int, int](), dict[str, list[int]]()
        for event in group.events:
            if event.kind == WIRE:
                node = self.wire_nodes[event.source]
                recorded[node].append(event.value)
                rows[node].append(group.size + event.row)
            elif event.entered and event.like == event.row:
                columns[event.row] = len(columns)
                owners.setdefault(self.block_names[event.source], []).append(columns[event.row])
        fresh = np.zeros((len(group.entering), len(columns)))
        for event in group.events:
            if event.entered and event.kind != WIRE:
                deviation = math.sqrt(variance(self.part(event)))
                fresh[:, columns[event.like]] += deviation * group.entering[:, event.row]
        order = [*(row for of in rows.values() for row in of), *range(group.size)]
        return recorded, GroupSlopes(group.lasting[order], fresh[order], owners, len(order) - group.size)
