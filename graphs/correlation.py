"""Correlation of parameters that are spread normally: z = L n with L L' = R, the matrix of the correlations."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.problem import shown
from proofmass.graphs.distributions import NORMAL, Spread
from proofmass.graphs.hints import like
from proofmass.graphs.table_entries import TableError, read_quantity


@dataclass(frozen=True)
class Correlation:
    """Coefficients between pairs of parameters, each pair in alphabetical order, and the factor that makes them."""

    pairs: tuple[tuple[str, str, float], ...] = ()
    names: tuple[str, ...] = ()
    factor: tuple[tuple[float, ...], ...] = ()

    def applied(self, normals: Mapping[str, float]) -> dict[str, float]:
        """Correlated standard normal deviates, made of independent ones."""
        return {
            name: sum(weight * normals[other] for weight, other in zip(row, self.names, strict=False))
            for name, row in zip(self.names, self.factor, strict=True)
        }


def correlation_of(pairs: Iterable[tuple[str, str, float]], spread: Mapping[str, Spread]) -> Correlation:
    """The correlation with these coefficients; raises `TableError` where they contradict each other."""
    ordered: dict[tuple[str, str], float] = {}
    for first, second, coefficient in pairs:
        for name in (first, second):
            if name not in spread or spread[name].shape not in NORMAL or math.isfinite(spread[name].truncated):
                expected = "a parameter of [spread] that is normal or lognormal and not truncated"
                hint = like(name, spread, "the spread parameters") if name not in spread else ""
                raise TableError("cannot be correlated", got=shown(name), expected=expected, hint=hint)
        if first == second:
            raise TableError("is correlated with itself", got=shown(first), hint="name another parameter")
        low, high = sorted((first, second))
        if ordered.setdefault((low, high), coefficient) != coefficient:
            raise TableError("has two coefficients", got=f"{low} and {high}", hint="leave one out")
    names = sorted({name for pair in ordered for name in pair})
    matrix = [[1.0 if a == b else ordered.get((min(a, b), max(a, b)), 0.0) for b in names] for a in names]
    return Correlation(tuple((*pair, r) for pair, r in sorted(ordered.items())), tuple(names), _factor(names, matrix))


def read_coefficient(table: Mapping[str, Any], key: str) -> float:
    """A coefficient between -1 and 1, both excluded; raises `TableError`."""
    value = read_quantity(table, key, "1")
    if not -1.0 < value < 1.0:
        raise TableError("out of range", key, shown(table[key]), "a number above -1 and below 1")
    return value


def _factor(names: Sequence[str], matrix: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], ...]:
    """The lower triangle of Cholesky; raises `TableError` where the matrix is not positive definite."""
    rows: list[list[float]] = []
    for i, name in enumerate(names):
        row: list[float] = []
        for j in range(i):
            row.append((matrix[i][j] - sum(row[k] * rows[j][k] for k in range(j))) / rows[j][j])
        rest = matrix[i][i] - sum(entry * entry for entry in row)
        if rest <= 1e-12:
            message = "the correlations contradict each other: their matrix is not positive definite"
            raise TableError(message, got=f"of {', '.join(names[: i + 1])}", hint=f"make those of {name} smaller")
        rows.append([*row, math.sqrt(rest)])
    return tuple(map(tuple, rows))
