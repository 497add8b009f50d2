"""Noise along a run: budgets where the orbit does not come back, as with a carrier that fits no number of ticks.

The covariance is followed along the run without noise (`over_runs`), and the budget is the mean
over its last part:

    S(f) = 2 / (r sum w^2) E |sum over n of w[n] y[n] exp(-2 pi i f n / r)|^2,   rms^2 = sum w^2 E[y^2] / sum w^2

y are the values of the output, r is their rate, and w is Hann's window over the last half of what
is followed. So lines are as wide as 1.5 over that time. For a stationary output this is Welch's
density (IEEE Trans. Audio and Electroacoustics 15, 1967, 70) in the mean over all runs.
"""

import math
from collections.abc import Sequence

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.declaration.units import short_unit
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.numbers import time_text
from proofmass.runner.analysis.noise.covariances import Stretch
from proofmass.runner.analysis.noise.noise_budget import QUANTISATION, NoiseBudget, NoiseSource
from proofmass.runner.analysis.noise.over_runs import followed
from proofmass.runner.analysis.spectrum.windows import window
from proofmass.runner.derivatives.dual_noise import given
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.bindings import Deviate
from proofmass.runner.plan.planned import Plan

_MOST = 24_000  # base ticks that are followed, up to the end of the run
_FEWEST, _LINES = 16, 120  # values of an output, and lines that are shown
_CHANGED = 0.1  # part by which the mean square of the second half of the window may differ from that of the first


def budgets_along(
    points: OperatingPoints, outputs: Sequence[str], band: tuple[float, float] | None, frequencies: Sequence[float]
) -> list[NoiseBudget | ModelError]:
    """Return the budgets of outputs over the last part of the graph's own run, or why not."""
    planned, ticks = points.plan, points.plan.ticks()
    nodes = [node_of(planned, output) for output in outputs]
    period = math.lcm(*(planned.stride(node) for node in nodes))
    first = max(0, ticks - _MOST) // period * period
    counts = {node: -(-ticks // planned.stride(node)) - first // planned.stride(node) for node in nodes}
    rates = {node: float(planned.schedule.base_rate) / planned.stride(node) for node in nodes}
    lines = {node: _lines(rates[node], counts[node] // 4 * 2, band, frequencies) for node in nodes}
    stretches = {
        node: Stretch(window("hann", count // 4 * 2), count - count // 4 * 2, lines[node] / rates[node])
        for node, count in counts.items()
    }
    try:
        begin = points.course.at(first).copy()
        found = followed(planned, nodes, ticks, stretches, begin=begin, course=points.course)
    except ModelError as error:
        return [error for _ in outputs]
    span = f"from {time_text(first * planned.period)} to {time_text(ticks * planned.period)}"
    note = f"the orbit does not come back: noise is that along the run, followed {span}, in the mean over the last half"
    return [
        _budget(planned, output, stretches[node], lines[node], rates[node], band, (note, *found.notes(node)))
        for output, node in zip(outputs, nodes, strict=True)
    ]


def _lines(rate: float, count: int, band: tuple[float, float] | None, frequencies: Sequence[float]) -> Array:
    """Return frequencies of lines: some, all in a band, or evenly on a logarithmic axis; none of a short output."""
    if count < _FEWEST:
        return np.zeros(0)
    if band is not None:
        whole = np.arange(count // 2 + 1) * rate / count
        return whole[(whole >= band[0]) & (whole < band[1])]
    return np.asarray(frequencies, float) if len(frequencies) else np.geomspace(2.0 / count, 0.5, _LINES) * rate


def _budget(
    planned: Plan,
    output: str,
    stretch: Stretch,
    lines: Array,
    rate: float,
    band: tuple[float, float] | None,
    notes: Sequence[str],
) -> NoiseBudget | ModelError:
    node, weight = node_of(planned, output), float(np.sum(stretch.window**2))
    if not len(lines):
        return refusal(planned, output, "the run is too short for its noise", f"{len(stretch.window)} values")
    densities = {name: power * (2.0 / (rate * weight)) for name, power in stretch.powers.items()}
    squares = {name: float(np.sum(square)) / weight for name, square in stretch.squares.items()}
    if band is not None:
        squares = {name: float(np.sum(density)) * rate / len(stretch.window) for name, density in densities.items()}
    total = sum(squares.values())
    if not total > 0.0:
        return refusal(planned, output, f"no noise reaches {output}", "none along the run")
    drawing = given(planned, (Deviate,))
    sources = [
        NoiseSource(
            block=name,
            kind=type(planned.blocks[name]).__name__ if name in drawing else QUANTISATION,
            rms=math.sqrt(square),
            share=square / total,
            density=densities[name],
        )
        for name, square in squares.items()
        if square > 0.0
    ]
    before, after = np.sum(list(stretch.squares.values()), axis=0)
    if not before:
        end = time_text(planned.ticks() * planned.period)
        message, got = f"the noise of {output} begins in the last quarter of the run", "none before it"
        return refusal(planned, output, message, got, f'--until "{end}" tells that of the value there')
    changed = f"its mean square in the last quarter is {after / before:.3g} times that in the one before"
    return NoiseBudget(
        output=output,
        unit=short_unit(planned.unit(node)),
        rate=rate,
        band=band or (0.0, 0.5 * rate),
        sources=tuple(sorted(sources, key=lambda source: -source.rms)),
        rms=math.sqrt(total),
        frequencies=lines,
        density=np.sum([source.density for source in sources], axis=0),
        input="",
        input_unit="",
        gain=np.zeros(0, dtype=complex),
        period=planned.period,
        notes=(*notes, changed) if abs(after - before) > _CHANGED * before else (*notes,),
    )


def refusal(planned: Plan, output: str, message: str, got: str, hint: str = "") -> ModelError:
    """Return the error of an output without a budget."""
    problem = Problem(message=message, key=output, got=got, hint=hint, path=("blocks", output.rpartition(".")[0]))
    return planned.graph.placed(problem).error
