"""Blocks that stand exactly at a corner where a graph is linearised, as a dead zone at its edge.

Two equal numbers that move apart compare in one way a little before, and in another a little later. Where a function
has the same value both ways, and other slopes, its slope is that of one side. All that is remembered moves along one
direction here, and what enters with it.
"""

import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.seeds import along
from proofmass.runner.derivatives.dual import SIGNALS, Ties, plain, slopes_of, with_ties
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError

_LOOKED = 32  # base ticks that are looked at
_CELLS = 256  # of buffers of a function at most, which is called on both sides
_ALIKE = 1e-9  # part of a slope


class _CornerTicks(DualTicks):
    """Ticks that note blocks whose functions have corners."""

    def __init__(self, *given: Any) -> None:
        self.corners = set[str]()
        super().__init__(*given)

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        function = super()._callable(block, behaviour)

        def call(*arguments: Any) -> Any:
            before, ties = _copied(arguments), Ties()
            with with_ties(ties):
                made = function(*arguments)
            if ties.found and sum(len(each) for each in before if isinstance(each, list)) <= _CELLS:
                with suppress(ArithmeticError, ValueError, IndexError):
                    if _bends(*(_on_a_side(function, before, side) for side in (1, -1))):
                        self.corners.add(self._at.rpartition(".")[0])
            return made

        return call


def _copied(arguments: Sequence[Any]) -> list[Any]:
    return [list(each) if isinstance(each, list) else each for each in arguments]


def _on_a_side(function: Callable[..., Any], arguments: Sequence[Any], side: int) -> list[Any]:
    """Return what a function makes, and its arguments then, where equal numbers compare as they do a little later."""
    own = _copied(arguments)
    with with_ties(Ties(side)):
        return [function(*own), *own]


def _bends(one: Any, other: Any) -> bool:
    """Return whether numbers are the same, and some of their slopes are not."""
    pairs = [*zip(_numbers(one), _numbers(other), strict=True)]
    return all(plain(a) == plain(b) for a, b in pairs) and any(_differ(a, b) for a, b in pairs)


def _numbers(of: Any) -> Iterator[Any]:
    if isinstance(of, list | tuple):
        for each in of:
            yield from _numbers(each)
    else:
        yield of


def _differ(one: Any, other: Any) -> bool:
    a, b = slopes_of(one, SIGNALS), slopes_of(other, SIGNALS)
    pairs = [(a.get(key, 0.0), b.get(key, 0.0)) for key in {*a, *b}]
    return any(not abs(x - y) <= _ALIKE * max(abs(x), abs(y)) for x, y in pairs)


def corner_notes(plan: Plan, ends: Ends, memory: Memory) -> tuple[str, ...]:
    """Return a note for each block of a map that stands at a corner within the first ticks from a memory on."""
    upstream, moving = ends.blocks(plan)
    dice, kinds = random.Random(1), {name: type(plan.blocks[name]) for name in sorted(moving)}
    changing = [name for name, kind in kinds.items() if {"update", "derivative"} & kind.functions.keys()]
    begin = along(plan, memory, changing, lambda: dice.uniform(0.5, 1.5))  # a table stays as it is
    given = plan.without_noise, begin, upstream, ends.inputs, ends.outputs, ends.cut, False
    with suppress(ModelError, TickError):
        ticks = _CornerTicks(*given)
        with suppress(ModelError, TickError):
            ticks.advance(begin.tick + min(ends.common_period(plan), _LOOKED), ())
        return tuple(
            f"{name} stands exactly at a corner: its slope is that of one side, and on the other side it is another"
            for name in sorted(ticks.corners)
        )
    return ()
