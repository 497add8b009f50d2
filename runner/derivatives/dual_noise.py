"""Ticks in dual numbers with a direction for each random number, and for each error of a quantiser.

Standard normal deviates are zero with the slope one. A quantiser passes on its input and adds an
error, zero with the slope one, counted in steps of the rounding.
In fixed point that is what integers drop.
"""

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.blocks.arithmetic.rounding import clip, two_level
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.checks.schedule import Beat
from proofmass.graphs.model.digraph import with_following
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual import SIGNALS, dual, plain, slopes_of, value_of
from proofmass.runner.derivatives.dual_functions import compared, for_duals, quantises, with_quantisers
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.plan.bindings import Binding, BufferBinding, Deviate, StateBinding, Tick, Time
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import Interpreter

DEVIATE, ROUNDING = "normal", "rounding error"  # stand for a port's name: no port has such a name
ONE_BIT = "error of one bit"
_ROLES = ("update", "derivative")


@dataclass(frozen=True)
class OneBitGain:
    """Model of a quantiser of one bit for small changes: v = gain y + e, with white e."""

    gain: float
    variance: float  # of e


Noisy = Mapping[
    str, tuple[OneBitGain, ...]
]  # blocks with noise, and their quantisers of one bit in the order of a tick
NOTHING: Noisy = MappingProxyType({})
_MOVING = (Deviate, StateBinding, BufferBinding, Time, Tick)


def noise_blocks(plan: Plan) -> Noisy:
    """The blocks that draw random numbers, or round values that vary: in fixed point, those that noise reaches."""
    drawing = given(plan, (Deviate,))
    sources = (drawing | (rounding_blocks(plan) & changing(plan, _MOVING))) - plan.digital.keys()
    return dict.fromkeys(sorted(sources | (reached(plan, set(sources)) & plan.digital.keys())), ())


def rounding_blocks(plan: Plan) -> set[str]:
    """The blocks that round, or drop bits in fixed point."""
    steps = {name: functions_in_loop(block).values() for name, block in plan.blocks.items()}
    return {name for name in steps if any(quantises(step.function) for step in steps[name])} | plan.digital.keys()


def one_model_each(noise: Noisy) -> bool:
    """Return whether no block has several models of one bit, between which plain Python chooses."""
    return all(len(models) < 2 for models in noise.values())


def rounds(part: str) -> bool:
    """Return whether the error of a rounding is meant, of a quantiser or of one place in a fixed-point block."""
    return part.startswith(ROUNDING)


def changing(plan: Plan, by: tuple[type, ...]) -> set[str]:
    """Blocks that do not always do the same: they, or what they depend on, are continuous or given such bindings."""
    own = {name for name, block in plan.blocks.items() if type(block).continuous()}
    return reached(plan, own | given(plan, by))


def given(plan: Plan, by: tuple[type, ...]) -> set[str]:
    """Blocks whose functions are given such bindings, as a state."""
    return {name for name in plan.blocks if any(isinstance(b, by) for b in _given(plan, name))}


def reached(plan: Plan, own: set[str]) -> set[str]:
    """Return some blocks and all that depend on them."""
    return with_following(own, plan.readers.__getitem__)


def _given(plan: Plan, name: str) -> Iterator[Binding]:
    """Yield the arguments of the functions of a block that run in the loop."""
    for function in functions_in_loop(plan.blocks[name]):
        yield from plan.bindings(name, function)


def functions_in_loop(block: Block) -> dict[str, Behaviour]:
    """The functions of a block that run in the loop, by output or role."""
    kind = type(block)
    return dict(kind.output_functions) | {role: kind.functions[role] for role in _ROLES if role in kind.functions}


class Followed(NamedTuple):
    """Paths that are followed in ticks with noise."""

    blocks: AbstractSet[str]  # which the outputs depend on
    moving: AbstractSet[str]  # of these, those whose numbers have slopes
    inputs: Sequence[Endpoint]  # something enters there
    outputs: Sequence[Endpoint]  # they are listened to
    noise: Noisy
    drawn: bool = False  # whether deviates have the values of a run, or are 0
    quantisers: Collection[str] = ()  # what they are given is listened to
    cut: bool = False  # what enters takes the place of what was there


class NoisyTicks(DualTicks):
    """Ticks in which blocks with `noise` name their sources, and what was rounded.

    Each adds a key (block, `DEVIATE` or `ROUNDING`, number) to `sources`. What `quantisers` among
    them are given is kept. Where they are `drawn`, deviates have the values of a run beside their
    slopes.
    """

    def __init__(self, *arguments: Any, noise: Noisy, drawn: bool = False, quantisers: Collection[str] = ()) -> None:
        self._noise, self._drawn, self._quantisers = noise, drawn, quantisers
        self._bits: dict[str, tuple[int, list[tuple[Any, Any]]]] = {}  # of a tick, by block
        self._known: set[tuple[str, str, int]] = set()
        self._last: dict[str, tuple[int, Any, tuple[str, str, int]]] = {}
        self._dropped: dict[str, tuple[int, list[tuple[Any, tuple[str, str, int]]]]] = {}  # in a tick, by block
        self._counts: Counter[tuple[str, str]] = Counter()
        super().__init__(*arguments)

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        owner = self._owner
        if owner not in self._noise:
            return super()._callable(block, behaviour)
        return with_quantisers(  # type: ignore[no-any-return]
            behaviour.function,
            lambda rule, value: self._rounded(owner, value, rule),
            lambda rule, *arguments: self._levelled(owner, rule, *arguments),
        )

    def _drop(self, owner: str, value: Any, drop: Drop) -> Any:
        """The value with the error of the bits that it loses, the same where it is made twice.

        What nothing moves is rounded alike in every tick.
        """
        if owner not in self._noise or not slopes_of(value, SIGNALS):
            return value
        tick, seen = self._dropped.get(owner, (-1, []))
        if tick != self._memory.tick:
            seen = []
            self._dropped[owner] = self._memory.tick, seen
        slopes = slopes_of(value, SIGNALS)
        same = (k for before, k in seen if plain(before) == plain(value) and slopes_of(before, SIGNALS) == slopes)
        key = next(same, None)
        if key is None:
            part = f"{ROUNDING} {len(seen)}"
            key = (owner, part, self._counts[owner, part])
            self._counts[owner, part] += 1
            self._keep(key, value)
            self.drops[key] = drop
            seen.append((value, key))
        return value + self._direction(key)

    def _getter(self, binding: Binding) -> Callable[[int], Any]:
        if not isinstance(binding, Deviate) or binding.block not in self._noise:
            return super()._getter(binding)
        beat = Beat(binding.divisor, binding.phase)
        first = beat.before(self._memory.tick)
        drawn = Interpreter._getter(self, binding) if self._drawn else None

        def deviate(tick: int) -> Any:
            slope = self._direction((binding.block, DEVIATE, beat.before(tick) - first))
            return slope if drawn is None else slope + drawn(tick)

        return deviate

    def _direction(self, key: tuple[str, str, int]) -> Any:
        if key not in self._known:
            self._known.add(key)
            self.sources.append(key)
        return dual(0.0, {key: 1.0}, SIGNALS)

    def _levelled(self, owner: str, rule: Any, first: Any, second: Any) -> Any:
        """The level that a rule chooses; of two levels by the gain of the quantiser."""
        value = compared(rule, first, second)
        if not self._noise[owner]:
            if rule is two_level:
                return for_duals(rule)(first, second)
            return self._rounded(owner, clip(value, 0.0, second), lambda rounded: rounded)
        tick, known = self._bits.get(owner, (-1, []))
        if tick != self._memory.tick:
            known = []
            self._bits[owner] = self._memory.tick, known
        for before, output in known:
            if before == value and slopes_of(before, SIGNALS) == slopes_of(value, SIGNALS):
                return output
        gain = self._noise[owner][min(len(known), len(self._noise[owner]) - 1)]
        key = (owner, ONE_BIT, self._counts[owner, ONE_BIT])
        self._counts[owner, ONE_BIT] += 1
        level = float(rule(plain(first), plain(second)))
        output = (
            level + gain.gain * (value - value_of(value, SIGNALS)) + math.sqrt(gain.variance) * self._direction(key)
        )
        known.append((value, output))
        return output

    def _same(self, before: Any, value: Any) -> bool:
        """Return whether a quantiser is given in a tick what it was given before."""
        return bool(before == value and slopes_of(before, SIGNALS) == slopes_of(value, SIGNALS))

    def _rounded(self, owner: str, value: Any, rule: Callable[[Any], Any]) -> Any:
        """The value with an error of its own; outputs that round one value in a tick err alike."""
        tick, given, key = self._last.get(owner, (-1, None, ("", "", 0)))
        if tick != self._memory.tick or not self._same(given, value):
            key = (owner, ROUNDING, self._counts[owner, ROUNDING])
            self._counts[owner, ROUNDING] += 1
            self._last[owner] = self._memory.tick, value, key
            self._keep(key, value)
        return rule(value) + self._direction(key)

    def _keep(self, key: tuple[str, str, int], value: Any) -> None:
        if key[0] in self._quantisers:
            self.quantised[key] = value
