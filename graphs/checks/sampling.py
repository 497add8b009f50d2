"""Runs that are sampled too seldom for what they hold: notes."""

from collections.abc import Iterator
from fractions import Fraction

from proofmass.blocks.declaration.catalog import family_of
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.shown_units import in_print
from proofmass.blocks.declaration.units import same_dimension
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.rates import base_rate, write_rate

_HELD = "held"  # integration.sources: values of sources are held from tick to tick
_FOLDED = {  # families whose frequencies are those of signals, and what becomes of one that is too high
    "sources": "the values are those of a lower one",
    "filters": "a sampled signal has none there",
    "statistics": "a sampled signal has none there",
}


def sampling_notes(flat: FlatGraph) -> Iterator[Problem]:
    """Yield notes on a graph whose wires are right: no probes, a run of one tick, frequencies above half a rate."""
    if not flat.probes and not flat.measures and not flat.exports:
        hint = 'add probes = ["block.output"] above the first block'
        yield Problem(message="no probes: a run records nothing", key="probes", hint=hint, note=True)
    rates = {name: flat.rates.get(name, flat.rate) for name, b in flat.blocks.items() if not type(b).continuous()}
    known = [rate for rate in rates.values() if rate is not None]
    if known and flat.duration is not None and flat.duration < 1 / base_rate(known):
        yield _one_tick(flat.duration, base_rate(known))
    for name, rate in rates.items():
        family = family_of(type(flat.blocks[name]))
        if rate is not None and family in _FOLDED:
            yield from _folded(flat, name, rate, family)


def _one_tick(duration: Fraction, rate: Fraction) -> Problem:
    return Problem(
        message="the run is over after the tick at time 0",
        got=f"{in_print(float(duration), 's', 6)}, where a tick lasts {in_print(float(1 / rate), 's', 6)}",
        hint="a run has the tick at time 0 and those up to its duration: raise the rate or the duration",
        note=True,
        path=("duration",),
    )


def _folded(flat: FlatGraph, name: str, rate: Fraction, family: str) -> Iterator[Problem]:
    """A block with a frequency that is not below half its rate."""
    block = flat.blocks[name]
    says = flat.integration
    if family == "sources" and says.sources != _HELD:
        if says.substeps is None or says.method not in ("auto", "runge_kutta_4"):
            return  # steps are chosen by the frequencies of sources, or by their error
        rate *= says.substeps
    for parameter in type(block).parameters.values():
        driven = any(wire.target == f"{name}.{parameter.name}" for wire in flat.wires)
        if parameter.kind is not float or driven or "frequency" not in parameter.name:
            continue
        value = getattr(block, parameter.name)
        if same_dimension(unit_of(block, parameter), "Hz") and 2 * value >= rate:
            yield Problem(
                message=f"the {parameter.name} is not below half the rate: {_FOLDED[family]}",
                got=f"{in_print(value, 'Hz', 6)}, in ticks at {write_rate(rate)}",
                expected=f"below {in_print(float(rate) / 2, 'Hz', 6)}",
                hint="raise the rate of the graph, or of the block",
                note=True,
                path=("blocks", name, parameter.name),
            )
