"""Standard errors, correlations, and combinations of unknowns that recordings do not determine.

The singular vectors of the derivatives, relative to the size of each unknown, are the combinations
that the recordings determine one by one; the inverse of a singular value is the relative
uncertainty of its combination. What is zero to begin with, as an offset, has no size of its own: it
is what moves an output by as much as is recorded.

Losses that count large residuals less leave larger errors than least squares: by the root of the
mean of psi^2 over the mean of psi', with psi half the derivative of the loss (Huber, Robust Statistics, 1981).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from proofmass.runner.design.identification.unknowns import Unknown
from proofmass.runner.host.arrays import AnyArray

UNCERTAIN = 0.5  # relative standard deviation of a combination that counts as not determined
_PART = 0.2  # of a combination, from which on an unknown takes part
_ALIKE = 0.02  # difference of parts that count as equal


@dataclass(frozen=True)
class Certainty:
    """Standard errors and correlations of the unknowns, and what is said of combinations that are not determined."""

    errors: AnyArray  # infinite where an unknown is not determined
    correlation: AnyArray  # NaN where one is not
    findings: tuple[str, ...]


def certainty(jacobian: AnyArray, values: AnyArray, unknowns: Sequence[Unknown], recorded: float = 0.0) -> Certainty:
    """Return what the derivatives of residuals, in units of the noise, say of the unknowns.

    `recorded` is the norm of the recorded outputs in these units.
    """
    sizes = np.array([abs(v) or u.scale for v, u in zip(values, unknowns, strict=True)])
    own = sizes.copy()
    for i, u in enumerate(unknowns):
        effect = float(np.linalg.norm(jacobian[:, i]))
        if u.start == 0.0 and effect > 0.0:
            sizes[i] = max(abs(float(values[i])), recorded / effect) or sizes[i]
    table = jacobian * sizes
    _, singular, turned = np.linalg.svd(table, full_matrices=False)
    largest = float(singular[0]) if len(singular) else 0.0
    floor = 1e-10 * largest
    determined = [i for i, s in enumerate(singular) if s > max(1.0 / UNCERTAIN, floor)]
    vague = [i for i in range(len(unknowns)) if i not in determined]
    covariance = (turned[determined].T / singular[determined] ** 2) @ turned[determined]
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0)) * sizes
    findings = []
    for i in vague:
        vector = turned[i]
        members = [int(k) for k in np.argsort(-np.abs(vector)) if abs(vector[k]) >= _PART]
        errors[members] = math.inf
        findings.append(_said(vector * sizes / own, members, unknowns, float(singular[i])))
    spread = np.where(np.isinf(errors), math.nan, np.sqrt(np.maximum(np.diag(covariance), 1e-300)))
    return Certainty(errors, covariance / np.outer(spread, spread), tuple(findings))


def freedom(jacobian: AnyArray, output_of: AnyArray, free: Sequence[float]) -> AnyArray:
    """Return the degrees of freedom of each unknown's error, from those of each output's noise.

    The variance is a sum over outputs, each known as well as its noise (Satterthwaite). What is
    known beforehand, below the rows of `output_of`, counts as certain.
    """
    rows = np.linalg.pinv(jacobian, rcond=1e-10) ** 2
    parts = [np.sum(rows[:, : len(output_of)][:, output_of == number], axis=1) for number in range(len(free))]
    whole, doubt = np.sum(rows, axis=1), sum(part**2 / of for part, of in zip(parts, free, strict=True))
    return np.asarray(whole**2 / np.maximum(doubt, 1e-300))


def widening(residuals: AnyArray, loss: str) -> float:
    """Return how many times the errors of a loss are those of least squares; residuals are in units of the noise."""
    squares = 1.0 + residuals**2
    match loss:
        case "robust":
            psi, slope = residuals / np.sqrt(squares), squares**-1.5
        case "outliers":
            psi, slope = residuals / squares, (2.0 - squares) / squares**2
        case _:
            return 1.0
    return float(np.sqrt(np.mean(psi**2)) / np.mean(slope))


def _said(vector: AnyArray, members: Sequence[int], unknowns: Sequence[Unknown], singular: float) -> str:
    names = [unknowns[k].written for k in members]
    if len(members) == 1:
        how = "changes nothing" if singular < 1e-6 else f"is known to {100.0 / singular:.2g} % of its size only"
        return f"not identifiable: {names[0]} {how} in these recordings"
    first = vector[members[0]]
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    if all(abs(vector[k] - first) < _ALIKE for k in members):
        known = "their ratio is" if len(members) == 2 else "their ratios are"
        return f"not identifiable: {listed}, all raised by the same factor, change nothing: only {known} determined"
    if len(members) == 2 and abs(vector[members[1]] + first) < _ALIKE:
        return f"not identifiable: raising {names[0]} and lowering {names[1]} by the same factor changes nothing"
    powers = ", ".join(f"{unknowns[k].written} by {100.0 * vector[k] / first:+.0f} %" for k in members)
    return f"not identifiable: {listed} together; changing {powers} changes nothing"
