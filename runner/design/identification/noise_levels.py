"""Levels of noise sources from the residuals of a fit: what is left of an output beside what the
others make there.

The mean square of an output is a sum over sources, each in proportion to the square of its level.
So the level of one source follows from the residuals' mean square less those of the others, by the
noise budget of the graph.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import scipy.special

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.model.flatten import flatten, inside
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.names import Missing, find_any
from proofmass.runner.analysis.noise.budget import noise
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget

_ASIDE = 0.025  # probability beyond each end of an interval of 95 %


@dataclass(frozen=True)
class NoiseLevel:
    """The level of a source, None where it is no more than what other sources make."""

    parameter: str
    unit: str
    before: float
    value: float | None
    half_width: float
    output: str

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "before": self.before,
            "value": self.value,
            "half_width": self.half_width if math.isfinite(self.half_width) else None,
            "unit": self.unit,
            "from_output": self.output,
        }


def noise_levels(
    graph: Graph, parameters: Sequence[str], left: Mapping[str, tuple[float, float]]
) -> Iterator[NoiseLevel]:
    """Yield the level of each source, from the output of which it makes the largest part.

    `left` has the sum of the squares of the residuals of each output, and how many degrees of
    freedom they have.
    """
    if not parameters:
        return
    flat = flatten(graph)
    budgets = _budgets(graph, left)
    for written in parameters:
        name = inside(graph, graph.exports.get(written, written))
        target = find_any(flat, name)
        if isinstance(target, Missing):
            raise Problem(message=target.message, key=written, hint=target.hint).error
        if not isinstance(target[1], Parameter) or target[1].kind is not float:
            raise Problem(message="is not a level of noise", key=written, hint="name a parameter").error
        block, parameter = split(name)
        before = float(getattr(flat.blocks[block], parameter))
        shares = {
            signal: sum(source.rms**2 for source in budget.sources if source.block == block)
            for signal, budget in budgets.items()
        }
        signal = max(shares, key=lambda key: shares[key] / budgets[key].rms ** 2)
        of_block, others = shares[signal], budgets[signal].rms ** 2 - shares[signal]
        if of_block <= 0.0 or before <= 0.0:
            message, hint = "makes no noise in the recorded outputs", "give it a value above zero to begin with"
            raise Problem(message=message, key=written, got=f"{before:g}", hint=hint).error
        squares, free = left[signal]
        variance = squares / free if free > 0.0 else 0.0
        rest = variance - others
        value = before * math.sqrt(rest / of_block) if rest > 0.0 else None
        half = math.inf if value is None else value * variance / rest * _larger_half(free)
        unit = short_unit(unit_of(target[0], target[1]))
        yield NoiseLevel(written, unit, before, value, half, signal)


def _budgets(graph: Graph, signals: Iterable[str]) -> dict[str, NoiseBudget]:
    """Return budgets of the outputs that have one; raises the first `ModelError` if none has."""
    budgets, refused = dict[str, NoiseBudget](), list[ModelError]()
    for signal in signals:
        try:
            budgets[signal] = noise(graph, signal)
        except ModelError as error:  # such as no noise reaches it: levels follow from the others
            refused.append(error)
    if not budgets:
        raise refused[0]
    return budgets


def _larger_half(free: float) -> float:
    """Return the larger half interval of a standard deviation, relative to it, by chi-square."""
    return math.sqrt(0.5 * free / float(scipy.special.gammaincinv(0.5 * free, _ASIDE))) - 1.0
