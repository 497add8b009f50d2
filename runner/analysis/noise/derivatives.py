"""Exact derivatives of the mean square of an output by every parameter.

With P = A P A' + B V B' and Q = A' Q A + C' C / r the mean square over all frequencies moves by

    2 tr(Q dA P A') + 2 tr(Q dB V B') + 2 / r tr(dC P C') + 2 / r tr(dD V D')

and that in a band by the integral of its density's derivative, 4 T / r^2 Re sum of v conj(h) dh
(`noise_map`). Either is linear in the changes of A, B, C and D: what stands with them is computed
once, and counts for all parameters.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.linearisation.covariance import summed
from proofmass.runner.analysis.linearisation.wire_response import Matrices
from proofmass.runner.analysis.noise.band import rule_of
from proofmass.runner.analysis.noise.noise_map import NoiseMap
from proofmass.runner.plan.planned import Plan

_AT_ONCE = 1 << 20  # complex numbers


@dataclass(frozen=True)
class OneMore:
    """Effect of one more of a whole number, such as a bit, on the rms."""

    parameter: str
    value: int
    change: float  # of the rms


def one_more(planned: Plan, blocks: Iterable[str], rms: float, again: Callable[[Graph], float]) -> Iterator[OneMore]:
    """Yield what one more of each whole number of some blocks does, by the budget of the graph that has it."""
    for name in blocks:
        block = planned.blocks[name]
        for parameter, declared in type(block).parameters.items():
            if declared.kind is not int:
                continue
            key, value = f"{name}.{parameter}", getattr(block, parameter)
            try:
                changed = again(with_parameters(planned.graph.root, {key: value + 1}))
            except ModelError:  # there is no more, as of an enumeration
                continue
            if changed != rms:
                yield OneMore(key, value, changed - rms)


def slopes_and_sizes(
    of: NoiseMap, band: tuple[float, float] | None, rms: float
) -> tuple[Mapping[str, float], Mapping[str, float]]:
    """Return the derivatives of the rms by parameters, over all frequencies or in a band, and their sums of sizes.

    Rounding leaves a part of the sizes.
    """
    by_matrices = _of_all(of) if band is None else _of_band(of, band)
    slopes, sizes = dict[str, float](), dict[str, float]()
    for name, slope in of.slopes.items():
        terms = [by * change / (2.0 * rms) for by, change in zip(by_matrices, slope, strict=True)]
        slopes[name] = sum(float(np.sum(term)) for term in terms)
        sizes[name] = sum(float(np.sum(np.abs(term))) for term in terms)
    return slopes, sizes


def _of_all(of: NoiseMap) -> Matrices:
    """The derivatives of the mean square by each entry of A, B, C and D."""
    a, b, c, d = of.matrices
    q, p = of.observed, summed(a, b * of.variances @ b.T)
    return 2.0 * q @ a @ p, 2.0 * q @ b * of.variances, 2.0 / of.values * c @ p, 2.0 / of.values * d * of.variances


def _of_band(of: NoiseMap, band: tuple[float, float]) -> Matrices:
    """Derivatives of the mean square in a band by the same entries."""
    points, weights, _ = rule_of(of, band)
    a, b, c, d = of.matrices
    total = tuple(np.zeros_like(part) for part in (a, b, c, d))
    width = max(1, _AT_ONCE // max(1, len(a) * (len(a) + d.shape[1])))
    for first in range(0, len(points), width):
        f, factor = points[first : first + width], weights[first : first + width]
        z = np.exp(2j * math.pi * f * of.period)
        turn = np.exp(-2j * math.pi * np.outer(f, np.arange(of.values)) / of.rate)
        resolvent = z[:, None, None] * np.eye(len(a)) - a
        into = np.linalg.solve(resolvent, np.broadcast_to(b.astype(complex), (len(f), *b.shape)))
        out = np.linalg.solve(resolvent.transpose(0, 2, 1), (turn @ c)[:, :, None])[:, :, 0]
        heard = np.einsum("fi,ij,fjk->fk", turn, c, into) + turn @ d
        power = heard.conj() * of.variances * (factor * 4.0 * of.period / of.values**2)[:, None]
        driven = np.einsum("fk,fjk->fj", power, into)
        parts = ((out, driven), (out, power), (turn, driven), (turn, power))
        for entry, (left, right) in zip(total, parts, strict=True):
            entry += np.real(left.T @ right)
    return total[0], total[1], total[2], total[3]
