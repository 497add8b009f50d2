"""Ends of maps: the wires that a map leads from and to, and what else enters."""

from collections.abc import Hashable
from dataclasses import dataclass, field, replace
from typing import Any

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.map_blocks import blocks_of_map, period_of_blocks
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, period_map
from proofmass.runner.derivatives.dual_noise import NOTHING, Noisy
from proofmass.runner.plan.planned import Plan


@dataclass(frozen=True)
class Ends:
    """Wires that a map leads from and to, cut or not, with `everything` upstream and the blocks
    whose noise enters.

    Maps from the same inputs to the outputs `beside` are asked for too, and repeat in the same
    period. Derivatives by parameters are those of `whole_turns` of all sources.
    """

    inputs: tuple[Endpoint, ...]
    outputs: tuple[Endpoint, ...]
    cut: bool = False
    everything: bool = False
    noise: Noisy = field(default_factory=lambda: NOTHING)
    beside: tuple[Endpoint, ...] = ()
    whole_turns: bool = False

    @property
    def key(self) -> Hashable:
        """A value that equal ends share."""
        return self.inputs, self.outputs, self.cut, self.everything, tuple(self.noise.items()), self.whole_turns

    @property
    def together(self) -> "Ends":
        """Ends from the same inputs to all outputs that are asked for."""
        return replace(self, outputs=tuple(sorted({*self.outputs, *self.beside})), beside=())

    def part_of(self, whole: PeriodMap, plan: Plan) -> PeriodMap:
        """Return the map between these ends, which is a part of that to all outputs together."""
        upstream, moving = self.blocks(plan)
        states = [i for i, entry in enumerate(whole.states) if entry[0] in moving]
        entering = [i for i, entry in enumerate(whole.inputs) if entry[:2] in self.inputs or entry[0] in upstream]
        wanted = [i for i, entry in enumerate(whole.outputs) if entry[:2] in self.outputs]
        return whole.part(states, wanted, entering)

    def wires_of(self, whole: PeriodMap) -> PeriodMap:
        """Return a map between these ends without the noise that enters, and without what quantisers are given."""
        entries = (whole.outputs, self.outputs), (whole.inputs, self.inputs)
        wanted = ([i for i, entry in enumerate(of) if entry[:2] in own] for of, own in entries)
        return replace(whole.part(range(whole.order), *wanted), later=tuple(map(self.wires_of, whole.later)))

    def blocks(self, plan: Plan) -> tuple[set[str], set[str]]:
        """Blocks that the outputs depend on, and those of them that the map has the states of."""
        return blocks_of_map(plan, self.inputs, self.outputs, self.everything, self.noise)

    def common_period(self, plan: Plan) -> int:
        """Base ticks of the period of the map."""
        return period_of_blocks(plan, self.blocks(plan)[1], [*self.inputs, *self.outputs])

    def map(self, plan: Plan, **options: Any) -> PeriodMap:
        """Return the map between them, with these options of `period_map`."""
        options |= {"cut": self.cut, "everything": self.everything, "noise": self.noise}
        return period_map(plan, self.inputs, self.outputs, **options)
