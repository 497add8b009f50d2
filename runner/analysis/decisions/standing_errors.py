"""Converters whose error stands still at an operating point: it makes no noise.

A run with noise shows it. What a converter rounds is the same in every tick, as a coefficient is,
or each value is one of its words already, as the level of another converter is.
"""

from collections.abc import Callable
from collections.abc import Set as AbstractSet
from typing import Any

from proofmass.blocks.arithmetic.rounding import clip, two_level
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.analysis.linearisation.map_blocks import upstream_of
from proofmass.runner.derivatives.dual_functions import LEVELS, RULES, quantises, with_functions
from proofmass.runner.derivatives.dual_noise import Noisy, given, reached
from proofmass.runner.plan.bindings import Deviate
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.reference.part import PartInterpreter

_VALUES, _TICKS = 4, 512  # least number of values of a converter, and of base ticks, in a run
_MOST_CALLS = 200_000  # of functions of blocks


def without_standing(plan: Plan, begin: Memory, noise: Noisy) -> Noisy:
    """Return blocks with noise but converters whose errors stand still in a run from a memory."""
    drawing = given(plan, (Deviate,))
    steps = {name: type(plan.blocks[name]).output_functions.values() for name in noise.keys() - drawing}
    rounding = {n for n in steps if n not in plan.digital and any(quantises(each.function) for each in steps[n])}
    ports = [(name, port) for name in sorted(rounding) for port in type(plan.blocks[name]).output_functions]
    upstream = upstream_of(plan, rounding)
    converters = {name: max(map(plan.stride, (p for p in ports if p[0] == name))) for name in rounding}
    most = _MOST_CALLS // max(1, len(upstream))
    seen = {name for name, stride in converters.items() if _VALUES * stride <= most}
    if not seen:
        return noise
    ticks = max(_TICKS, _VALUES * max(converters[name] for name in seen))
    run = _Errors(plan, begin.copy(), upstream, seen)
    try:
        run.advance(begin.tick + min(ticks, most), ())
    except TickError:  # a run with noise may fail where small noise does not
        return noise
    by_noise = reached(plan, drawing)
    standing = {name for name in seen if run.stands(name, name in by_noise)}
    return {name: own for name, own in noise.items() if name not in standing}


class _Errors(PartInterpreter):
    """A run with noise that notes what converters are given, and their errors in steps."""

    def __init__(self, plan: Plan, memory: Memory, upstream: AbstractSet[str], seen: AbstractSet[str]) -> None:
        self._seen = seen
        self._values: dict[str, set[float]] = {name: set() for name in seen}
        self._errors: dict[str, set[float]] = {name: set() for name in seen}
        super().__init__(plan, plan.graph.seed, memory, upstream)

    def stands(self, name: str, by_noise: bool) -> bool:
        """Return whether the error of a converter never changed, for several values where noise reaches it."""
        values, errors = self._values[name], self._errors[name]
        return len(errors) == 1 and (len(values) > 1 or not by_noise)

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        owner = self._owner
        if owner not in self._seen:
            return super()._callable(block, behaviour)
        rules = {rule: self._rounding(owner, rule) for rule in RULES}
        levels = {rule: self._choosing(owner, rule) for rule in LEVELS if rule is not two_level}
        return with_functions(behaviour.function, {**rules, **levels})

    def _rounding(self, owner: str, rule: Callable[[Any], Any]) -> Callable[[Any], Any]:
        def rounded(value: Any) -> Any:
            return self._noted(owner, value, rule(value))

        return rounded

    def _choosing(self, owner: str, rule: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        def level(value: Any, last: Any) -> Any:
            return self._noted(owner, clip(value, 0.0, last), rule(value, last))

        return level

    def _noted(self, owner: str, value: Any, made: Any) -> Any:
        self._values[owner].add(float(value))
        self._errors[owner].add(float(made) - float(value))
        return made
