"""The map of the digital part of a graph over one common period, in exact numbers.

    registers' = A registers + B inputs + E errors + c

The blocks' own functions are called with affine forms for their mantissas (`fixed.affine`).
Registers that nothing changes count as constants. Inputs are what converters give: any mantissas
within their ranges, one for each tick.
"""

from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.checks.schedule import ConstantsOf
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.runner.analysis.linearisation.map_blocks import period_of_blocks
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS, place_of, put
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.fixed.affine import (
    INPUT,
    REGISTER,
    AffineForms,
    AffineMantissa,
    FormBounds,
    NotAffineError,
    RoundingError,
)
from proofmass.runner.plan.bindings import Binding, Tick
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import Interpreter, TickError

MantissaRanges = Mapping[Endpoint, tuple[int, int]]  # of the mantissas that converters give
AffineNumber: TypeAlias = AffineMantissa | int
_CHANGES = "write it as sums and products with constants, or leave it out"


@dataclass(frozen=True)
class DigitalMap:
    """Registers with their start and what they are after a period, and all met on the way."""

    start: tuple[int, ...]
    following: tuple[AffineNumber, ...]
    inputs: tuple[tuple[Endpoint, int], ...]  # output of a converter, and the number of its value in the period
    ranges: tuple[tuple[int, int], ...]  # of these
    errors: tuple[RoundingError, ...]
    conditions: tuple[FormBounds, ...]
    outputs: Mapping[Endpoint, tuple[AffineNumber, ...]]  # values of the outputs that were asked for, in a period
    ticks: int  # of the period


def digital_map(
    plan: Plan, blocks: AbstractSet[str], ranges: MantissaRanges, outputs: Sequence[Endpoint]
) -> DigitalMap:
    """Return the map of some digital blocks; `ranges` has all that enters them.

    Raises `ModelError` where a block does what is not affine.
    """
    ticks = period_of_blocks(plan, {*blocks}, [*ranges, *outputs])
    begin = start(plan)
    initial = _registers(begin, blocks, ranges)
    moving: dict[LastingPlace, None] = {}
    while True:
        engine = _Ticks(plan, begin.copy(), blocks, ranges, outputs)
        for number, place in enumerate(moving):
            put(engine.memory(), place, engine.forms.symbol(REGISTER, number, Fraction(initial[place])))
        engine.follow(ticks)
        following = _registers(engine.memory(), blocks, ranges)
        moved = [
            place
            for place, value in following.items()
            if place not in moving and (isinstance(value, AffineMantissa) or value != initial[place])
        ]
        if not moved:
            break
        moving |= dict.fromkeys(moved)
    return DigitalMap(
        tuple(int(initial[place]) for place in moving),
        tuple(following[place] for place in moving),
        tuple(engine.entered),
        tuple(ranges[node] for node, _ in engine.entered),
        tuple(engine.forms.errors),
        engine.forms.conditions,
        {node: tuple(values) for node, values in engine.recorded.items()},
        ticks,
    )


class _Ticks(Interpreter):
    """Ticks of some digital blocks on affine forms; what converters give is a new symbol in each of their ticks."""

    def __init__(
        self, plan: Plan, memory: Memory, blocks: AbstractSet[str], ranges: MantissaRanges, outputs: Sequence[Endpoint]
    ) -> None:
        self.forms, self._ranges = AffineForms(), ranges
        self.entered: list[tuple[Endpoint, int]] = []
        self.recorded: dict[Endpoint, list[AffineNumber]] = {node: [] for node in outputs}
        self._counts: dict[Endpoint, int] = dict.fromkeys(ranges, 0)
        super().__init__(replace(plan, solvers=(), probes=()), seed=0, memory=memory)
        self._outputs = [
            (step, beat, self._entering(step) if step in ranges else self._noted(step, compute))
            for step, beat, compute in self._outputs
            if not isinstance(step, ConstantsOf) and (step[0] in blocks or step in ranges)
        ]
        self._updates = [update for update in self._updates if update[0] in blocks]
        self._folds = [fold for fold in self._folds if fold[0] in blocks]

    def follow(self, ticks: int) -> None:
        """Advance over a period; raises `ModelError` where a block does what is not affine."""
        try:
            self.advance(ticks, ())
        except TickError as error:
            raise self.filled.graph.placed(_not_affine(error)).error from error

    def _entering(self, node: Endpoint) -> Callable[[int], Any]:
        def enter(tick: int) -> Any:
            low, high = self._ranges[node]
            number = self._counts[node]
            self._counts[node] += 1
            self.entered.append((node, number))
            return low if low == high else self.forms.symbol(INPUT, len(self.entered) - 1, Fraction(low + high, 2))

        return enter

    def _noted(self, node: Endpoint, compute: Callable[[int], Any]) -> Callable[[int], Any]:
        def noted(tick: int) -> Any:
            value = compute(tick)
            if node in self.recorded:
                self.recorded[node].append(value)
            return value

        return noted

    def _counted(self, name: str, function: str) -> Callable[..., Any]:
        reference = self.filled.digital[name].steps[function].reference

        def call(*arguments: Any) -> Any:
            self.forms.at = f"{name}.{function}"
            return reference(*arguments)

        return call

    def _getter(self, binding: Binding) -> Callable[[int], Any]:
        if isinstance(binding, Tick):
            return _refused_tick
        return super()._getter(binding)

    def _finite(self, value: Any) -> bool:
        return True


def _refused_tick(tick: int) -> Any:
    raise NotAffineError("the number of the tick")


def _registers(memory: Memory, blocks: AbstractSet[str], ranges: MantissaRanges) -> dict[LastingPlace, Any]:
    """Return all numbers that last from one tick to the next, by their places."""
    states = NO_RINGS.states_of(memory, sorted(blocks))
    numbers = {place_of(memory, entry, NO_RINGS): value for entry, value in states}
    for node, wire in memory.wires.items():
        if node[0] in blocks or node in ranges:
            held = wire if isinstance(wire, list) else [wire]
            numbers |= {("wire", node, i): value for i, value in enumerate(held)}
    return numbers


def _not_affine(error: TickError) -> Problem:
    cause = error.__cause__ or error.value
    block = split(error.at)[0]
    return Problem(
        message=f"{error.at} has no exact linear form: {cause}",
        key=f"blocks.{block}",
        hint=_CHANGES,
        path=("blocks", block),
    )
