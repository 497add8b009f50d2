"""Levels of noise sources from the residuals of a fit: what is left of an output beside what the
others make there.

The mean square of an output is a sum over sources, each in proportion to the square of its level.
So levels follow from the residuals' mean squares less those of the other sources, by the noise
budget of the graph: one for each output.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.optimize
import scipy.special

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.names import Missing, find_any
from proofmass.runner.analysis.noise.budget import noise
from proofmass.runner.analysis.noise.noise_budget import NoiseBudget
from proofmass.runner.host.arrays import AnyArray

_PROPORTIONAL = 0.01  # part by which the mean square of a source may miss the square of its level
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


@dataclass(frozen=True)
class _Source:
    """A source whose level is wanted: its block, its parameter as it is, and its mean square in each output."""

    written: str
    block: str
    unit: str
    before: float
    squares: Mapping[str, float]


def noise_levels(
    graph: Graph, parameters: Sequence[str], left: Mapping[str, tuple[float, float]]
) -> Iterator[NoiseLevel]:
    """Yield the level of each source, from the outputs of which they make the largest parts.

    `left` has the sum of the squares of the residuals of each output, and how many degrees of
    freedom they have.
    """
    if not parameters:
        return
    flat, budgets = flatten(graph), _budgets(graph, left)
    sources = [_source(graph, flat, written, budgets) for written in parameters]
    signals = _outputs(sources, budgets)
    table = np.array([[source.squares[s] / source.before**2 for source in sources] for s in signals])
    if np.linalg.matrix_rank(table / np.linalg.norm(table, axis=0)) < len(sources):
        raise _undetermined(sources[-1].written)
    variances = np.array([left[s][0] / left[s][1] if left[s][1] > 0.0 else 0.0 for s in signals])
    others = np.array([budgets[s].rms ** 2 - sum(source.squares[s] for source in sources) for s in signals])
    found = np.sqrt(scipy.optimize.nnls(table, variances - others)[0])
    _refuse_others(graph, sources, signals, found)
    parts = np.linalg.inv(table) * variances * [_larger_half(left[s][1]) for s in signals]
    for source, signal, value, half in zip(sources, signals, found, np.linalg.norm(parts, axis=1), strict=True):
        level, width = (float(value), float(half / value)) if value > 0.0 else (None, math.inf)
        yield NoiseLevel(source.written, source.unit, source.before, level, width, signal)


def _source(graph: Graph, flat: FlatGraph, written: str, budgets: Mapping[str, NoiseBudget]) -> _Source:
    name = inside(graph, graph.exports.get(written, written))
    target = find_any(flat, name)
    if isinstance(target, Missing):
        raise Problem(message=target.message, key=written, hint=target.hint).error
    if not isinstance(target[1], Parameter) or target[1].kind is not float:
        raise Problem(message="is not a level of noise", key=written, hint="name a parameter").error
    block, parameter = split(name)
    before = float(getattr(flat.blocks[block], parameter))
    squares = _squares(block, budgets)
    if not any(squares.values()) or before <= 0.0:
        message, hint = "makes no noise in the recorded outputs", "give it a value above zero to begin with"
        raise Problem(message=message, key=written, got=f"{before:g}", hint=hint).error
    return _Source(written, block, short_unit(unit_of(target[0], target[1])), before, squares)


def _squares(block: str, budgets: Mapping[str, NoiseBudget]) -> dict[str, float]:
    return {
        signal: sum(source.rms**2 for source in budget.sources if source.block == block)
        for signal, budget in budgets.items()
    }


def _outputs(sources: Sequence[_Source], budgets: Mapping[str, NoiseBudget]) -> list[str]:
    """Return an output for each source, so that they make the largest parts together; refuses sources without."""
    shares = np.array([[s.squares[key] / budget.rms**2 for key, budget in budgets.items()] for s in sources])
    rows, columns = scipy.optimize.linear_sum_assignment(shares, maximize=True)
    chosen = {int(row): list(budgets)[column] for row, column in zip(rows, columns, strict=True) if shares[row, column]}
    for number, source in enumerate(sources):
        if number not in chosen:
            raise _undetermined(source.written)
    return [chosen[number] for number in range(len(sources))]


def _undetermined(written: str) -> ModelError:
    message, expected = "is not determined beside the other levels", "an output of its own for each level"
    return Problem(message=message, key=written, expected=expected, hint="free one level of those that make it").error


def _refuse_others(graph: Graph, sources: Sequence[_Source], signals: Sequence[str], found: AnyArray) -> None:
    """Refuse what is no level: noise that does not grow in proportion to it, as by a temperature or a corner."""
    values = {s.written: float(value) or s.before for s, value in zip(sources, found, strict=True)}
    with_them = _budgets(with_parameters(graph, values), signals)
    for source, signal in zip(sources, signals, strict=True):
        grown = (values[source.written] / source.before) ** 2 * source.squares[signal]
        if not math.isclose(_squares(source.block, with_them)[signal], grown, rel_tol=_PROPORTIONAL):
            message, hint = "is not a level of noise", "name one that the noise of its block grows in proportion to"
            raise Problem(message=message, key=source.written, hint=hint).error


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
