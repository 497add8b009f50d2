"""Runs of a plan with different parameters in the lanes of vector instructions."""

import threading
from collections.abc import Iterable, Mapping

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.call_numbers import refuse_counts
from proofmass.graphs.model.changes import changed_blocks
from proofmass.graphs.model.graph import split
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.keys import WireOf
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import varied
from proofmass.runner.targets.machine_code import has_wide_vectors
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes

LEAST = 8  # lanes
MOST = 64
NEAR = 112 * 1024  # bytes of all lanes


def lane_counts() -> tuple[int, ...]:
    """Return the numbers of lanes to choose from on this processor, the largest first.

    Measured: 32 lanes suit vectors of 512 bits. Where they have 256 bits and half as many
    registers, 16 are faster by a quarter in closed loops; where they have 128, 16 and 32 are alike.
    """
    return (32, 16, LEAST) if has_wide_vectors() else (16, LEAST)


def lanes_for(runs: int, size: int) -> int:
    """Return the number of lanes for so many compiled runs of so many bytes each; 0 for a few runs.

    The most that are filled several times and stay near the processor: with 48 KB of cache of the
    first level graphs of the library were fastest with the most lanes that take at most 112 KB
    together.
    """
    fitting = (lanes for lanes in lane_counts() if runs >= 4 * lanes and lanes * size <= NEAR)
    return next(fitting, LEAST if 2 * runs >= LEAST else 0)


def whole_lanes(lanes: int) -> int:
    """Return the least number of lanes from `lanes` on for which LLVM makes code: a power of two, 2
    to 64; 0 stays.

    Rows of other lengths would lie across the boundaries of vectors, and LLVM ends the process
    where it has no instructions for them. Lanes without a run are idle. Raises `ModelError`.

    >>> whole_lanes(0), whole_lanes(1), whole_lanes(10), whole_lanes(64)
    (0, 2, 16, 64)
    """
    refuse_counts(lanes=(lanes, 0, MOST))
    return max(2, 1 << (lanes - 1).bit_length()) if lanes else 0


class SideBySide:
    """Runs a plan with varied parameters, `lanes` at a time; bits are those of each run alone."""

    def __init__(self, plan: Plan, seed: int, ticks: int, lanes: int, names: Iterable[str]) -> None:
        self.plan, self.seed, self.ticks, self.lanes = plan, seed, ticks, whole_lanes(lanes)
        nodes = {name: split(name) for name in names}
        self.compiled = CompiledLanes(plan, frozenset(nodes.values()), self.lanes)
        self._settled = [name for name, node in nodes.items() if node[0] in self.compiled.settled]
        self._free = {name: node for name, node in nodes.items() if name not in self._settled}

    def measured(
        self, values: Mapping[str, AnyArray], noise: AnyArray, stop: threading.Event | None = None
    ) -> tuple[AnyArray, AnyArray]:
        """Return the measures, a row for each run, and which rows are valid; the others are re-run individually.

        `values` has an array for each parameter by `block.parameter`, `noise` the numbers that
        noise follows from. Raises `StoppedError` soon after the event is set.
        """
        able, measured = self._inside(values, len(noise)), np.full((len(noise), len(self.plan.measures)), np.nan)
        plans: list[Plan] = []
        if self._settled:
            made = {int(number): self._plan(values, int(number)) for number in np.flatnonzero(able)}
            able[[number for number, plan in made.items() if plan is None]] = False
            plans = [plan for plan in made.values() if plan is not None]
        if not able.any():
            return measured, able
        free = {node: values[name][able] for name, node in self._free.items()}
        lanes = Lanes(self.compiled, self.seed, noise[able], free, plans)
        lanes.advance(self.ticks, stop)
        if self.plan.measures:
            measured[able] = np.stack([lanes.value(WireOf(*measure.node)) for measure in self.plan.measures], axis=1)
            measured[:, [self.ticks <= measure.first for measure in self.plan.measures]] = np.nan  # they have not begun
        able[able] = lanes.sound()
        return measured, able

    def _inside(self, values: Mapping[str, AnyArray], sensors: int) -> AnyArray:
        """Return which sensors have parameters within their bounds."""
        inside = np.ones(sensors, dtype=bool)
        for drawn in values.values():
            inside &= np.isfinite(drawn)
        for name, (block, parameter) in self._free.items():
            declared, drawn = type(self.plan.blocks[block]).parameters[parameter], values[name]
            if not (declared.inside(drawn.min()) and declared.inside(drawn.max())):
                inside &= np.array([declared.inside(value) for value in drawn.tolist()])
        return inside

    def _plan(self, values: Mapping[str, AnyArray], number: int) -> Plan | None:
        """Return the plan of a sensor, with the blocks that are computed before it runs.

        None if planning fails, or if it has buffers of other lengths than the lanes have.
        """
        try:
            settled = {name: float(values[name][number]) for name in self._settled}
            plan = varied(self.plan, changed_blocks(self.plan.blocks, settled))
        except ModelError:
            return None
        return plan if plan.same_sizes(self.plan) else None
