"""A check that noise is small: where it moves the operating point, the map there must do the same to it.

A product of two noises, or the root of a sum of squares of noise alone, has a slope that noise itself sets. The
map is taken again along a run with noise, at several instants where periods are short: a converter may be full at most
of them. All maps are given the same noise: the rms of what their outputs differ by tells them apart, even where each
has the same rms, as a slope that only turns.
"""

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import with_spectra
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Forward
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.noise.noise_map import NoiseMap, noise_map, summed
from proofmass.runner.reference.interpret import TickError

_TICKS = 512  # base ticks of a run with noise, or one period
_INSTANTS, _MAPPED = 8, 64  # maps along it, and base ticks of them, or one period
_APART = 0.5  # of the rms; a square of noise about twice its rms then has an rms that is 6 % off


def strained(about: Linearisation, ends: Ends, target: Endpoint, whole: PeriodMap, to_output: NoiseMap) -> str:
    """Return a note where the noise of an output is another at what a run with noise gets to, or ""."""
    if not to_output.settles or not to_output.mean_squares().any():
        return ""
    there = _drawn(about, ends.together, whole) or _drawn(about, replace(ends, beside=()), whole)
    maps = (noise_map(with_spectra(ends.part_of(one, about.plan), ends.noise), target) for one in there)
    squares = [difference_squared(to_output, moved) for moved in maps if moved.settles]
    mean = sum(squares) / max(1, len(squares))
    apart = math.sqrt(max(0.0, mean) / float(sum(to_output.mean_squares())))
    if apart < _APART:
        return ""
    return (
        "noise is not small here: along a run with noise the same noise moves the output otherwise, by"
        f" {100.0 * apart:.0f} % of this rms; a study of many runs says what the rms is"
    )


def _drawn(about: Linearisation, ends: Ends, whole: PeriodMap) -> list[PeriodMap]:
    """Return maps of a period along a run with noise; none if it has none, which is no refusal of a budget."""
    planned, kept = about.plan, about.course.kept
    ticks = round(whole.period / planned.period)
    key = "drawn", ends.key, whole.tick, ticks
    if key not in kept:
        kept[key] = []
        instants = min(_INSTANTS, max(1, _MAPPED // ticks))
        with suppress(ModelError, TickError):
            run, apart = Forward(planned, about.course.at(whole.tick)), max(1, _TICKS // (ticks * instants)) * ticks
            for number in range(1, instants + 1):
                memory = run.to(whole.tick + number * apart)
                more = ends.map(planned, memory=memory, span=ticks, drawn=True, slopes=about.course.slopes)
                kept[key].append(more)
    drawn: list[PeriodMap] = kept[key]
    return drawn


def difference_squared(first: NoiseMap, second: NoiseMap) -> float:
    """Return the mean square of what the outputs of two maps differ by, where both are given the same noise.

    That is E[y1^2] + E[y2^2] - 2 E[y1 y2]. With X = A1' X A2 + C1' C2 / r the last is a sum over the columns of
    v (B1' X B2 + D1' D2 / r).
    """
    places = [{entry: column for column, entry in enumerate(of.inputs)} for of in (first, second)]
    common = [entry for entry in first.inputs if entry in places[1]]
    columns = [[of[entry] for entry in common] for of in places]
    (a1, b1, c1, d1), (a2, b2, c2, d2) = first.matrices, second.matrices
    x = summed(a1.T, c1.T @ c2 / first.values, a2.T)
    shared = np.einsum("ik,ij,jk->k", b1[:, columns[0]], x, b2[:, columns[1]])
    shared += np.einsum("ik,ik->k", d1[:, columns[0]], d2[:, columns[1]]) / first.values
    squares = float(sum(first.mean_squares()) + sum(second.mean_squares()))
    return squares - 2.0 * float(first.variances[columns[0]] @ shared)
