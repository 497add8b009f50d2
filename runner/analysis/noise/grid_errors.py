"""Errors of quantisers where their inputs lie on a grid (`grids`): at an operating point, and along a run."""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from statistics import fmean
from typing import TYPE_CHECKING, get_args

from proofmass.blocks.arithmetic.mantissa import Drop, Rounding
from proofmass.blocks.arithmetic.rounding import round_half_even
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import with_spectra
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.noise.grids import CONVERTED, COUNTED, NEARLY_WHOLE, on_grids, scaled
from proofmass.runner.analysis.noise.validity import APART
from proofmass.runner.derivatives.dual_functions import reaches
from proofmass.runner.derivatives.dual_noise import functions_in_loop, rounding_blocks
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan

if TYPE_CHECKING:
    from proofmass.runner.targets.native_slopes import SlopeCode

_SPAN = 64  # ticks at the end of a run
_STRETCH = 256  # ticks of a period at a time, where nothing lasts from one to the next
_RULES: tuple[Rounding, ...] = get_args(Rounding)


@dataclass(frozen=True)
class GridErrors:
    """Errors of roundings, by block and part: their sizes, and how far they are from white and uniform."""

    sizes: Mapping[Endpoint, float]  # deviation of the error as it is over that of one that is uniform over a step
    apart: Mapping[Endpoint, float]  # of the mean square

    def of(self, whole: PeriodMap) -> PeriodMap:
        """Return a map with the errors of these sizes."""
        return scaled(whole, {entry: self.size(entry[:2], whole.drops.get(entry)) for entry in whole.inputs})

    def size(self, place: Endpoint, drop: Drop | None) -> float:
        """Return the size of what enters at a place: of an error that is not known, by what is dropped."""
        return self.sizes.get(place, size_of(1 << drop.bits, 0.0, drop.rounding) if drop else 1.0)

    def notes(self, blocks: Collection[str]) -> list[str]:
        """Return notes on the errors of some blocks that are neither white nor uniform."""
        largest = dict[str, float]()
        for (block, _), apart in sorted(self.apart.items()):
            if block in blocks and apart > APART:
                largest[block] = max(largest.get(block, 0.0), min(100.0 * apart, 100.0))
        return [
            f"{block}: noise moves what it rounds too little, or by too few levels, for an error that is white and"
            f" uniform: unless signals move it more, its mean square may be off by up to {percent:.3g} %"
            for block, percent in largest.items()
        ]


def errors_about(about: Linearisation, ends: Ends) -> tuple[GridErrors, tuple[PeriodMap, ...]]:
    """Return the errors upstream of some outputs at an operating point, and the maps to what quantisers are given.

    Where nothing lasts from tick to tick on the way there, they are those of short stretches of the period.
    """
    point, kept = about.point_of(ends), about.course.kept
    quantisers = _quantisers(about.plan, ends)
    key = "to quantisers", quantisers, point.map.tick, point.ticks, tuple(ends.noise.items())
    if key not in kept:
        maps = [with_spectra(whole, ends.noise) for whole in _to_quantisers(about, ends, point, quantisers)]
        kept[key] = _errors(about.plan, maps), tuple(maps)
    found: tuple[GridErrors, tuple[PeriodMap, ...]] = kept[key]
    return found


def _to_quantisers(
    about: Linearisation, ends: Ends, point: OrbitPoint, quantisers: Collection[str]
) -> Iterator[PeriodMap]:
    """Yield the maps to what quantisers are given in a period: entries of one map would be ticks squared."""
    own = Ends((), (), noise=ends.noise)
    given = {**point.where, "quantisers": quantisers}
    first = own.map(about.plan, **{**given, "span": 1}) if point.memory and point.ticks > _STRETCH else None
    if first is None or first.order:
        yield own.map(about.plan, **given, slopes=about.course.slopes)
        return
    run, end = about.course.from_memory(point.memory), first.tick + point.ticks
    for tick in range(first.tick, end, _STRETCH):
        given |= {"memory": run.to(tick), "span": min(_STRETCH, end - tick)}
        yield own.map(about.plan, **given, slopes=about.course.slopes)


def errors_along(
    plan: Plan, at: Callable[[int], Memory], ends: Ends, last: int, code: "SlopeCode | None"
) -> GridErrors:
    """Return the errors upstream of some outputs in the last ticks of a run; what stands there is not looked at.

    `at` returns the memory of the run at a tick, and `code` follows its ticks where there is such.
    """
    quantisers = _quantisers(plan, ends)
    if not quantisers:
        return GridErrors({}, {})
    longest = max(plan.stride((name, port)) for name in quantisers for port in type(plan.blocks[name]).outputs)
    span = min(last, COUNTED * longest, _SPAN)
    options = {"memory": at(last - span), "span": span, "slopes": lambda *_: code, "quantisers": quantisers}
    whole = Ends((), (), noise=ends.noise).map(plan, **options)
    return _errors(plan, [with_spectra(whole, ends.noise)], moving=True)


def _quantisers(plan: Plan, ends: Ends) -> tuple[str, ...]:
    """Return the blocks upstream of some outputs that round what noise moves."""
    return tuple(sorted(rounding_blocks(plan) & ends.noise.keys() & ends.blocks(plan)[0]))


def _errors(planned: Plan, maps: Iterable[PeriodMap], moving: bool = False) -> GridErrors:
    """Return the errors of maps to quantisers, or those of what moves there."""
    found = dict[Endpoint, list[tuple[float, float]]]()
    for whole in maps:
        drops = {entry: Drop(CONVERTED, _rule(planned.blocks[entry[0]])) for entry in whole.outputs} | {**whole.drops}
        for entry, error in on_grids(replace(whole, drops=drops)).items():
            if error.motion or not moving:
                size = size_of(error.levels or 1 << drops[entry].bits, error.offset, drops[entry].rounding)
                found.setdefault(entry[:2], []).append((size, error.apart))
    sizes = {place: math.sqrt(fmean(size**2 for size, _ in each)) for place, each in found.items()}
    apart = {
        place: 1.0 if any(abs(size - sizes[place]) > NEARLY_WHOLE for size, _ in each) else max(of for _, of in each)
        for place, each in found.items()
    }
    return GridErrors(sizes, apart)


def _rule(block: Block) -> Rounding:
    """Return the rule by which a converter rounds."""
    for rule in _RULES:
        if rule == getattr(block, "rounding", None):
            return rule
    to_even = any(reaches(each.function, (round_half_even,)) for each in functions_in_loop(block).values())
    return "half_even" if to_even else "half_up"


def size_of(levels: int, offset: float, rule: Rounding) -> float:
    """Return the deviation of an error over that of one that is uniform over a step, all levels as likely.

    Ties made even add to it. Of a magnitude that is cut the sign turns with the number.
    """
    part = 1.0 / levels
    if rule == "toward_zero":
        return math.sqrt(2.0 * (1.0 - part) * (2.0 - part) if _is_whole(levels * offset) else 4.0 - part**2)
    ties = rule == "half_even" and _is_whole(levels * (0.5 - offset))
    return math.sqrt(1.0 + 2.0 * part**2 if ties else 1.0 - part**2)


def _is_whole(number: float) -> bool:
    return abs(number - round(number)) < NEARLY_WHOLE
