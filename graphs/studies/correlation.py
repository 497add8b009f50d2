"""Correlation of parameters that are spread normally: z = L n with L L' = R, the matrix of the correlations."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown
from proofmass.graphs.studies.distributions import NORMAL, Spread
from proofmass.graphs.studies.table_entries import read_quantity

_ROUNDING = 1e-12  # of a pivot


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
    """The correlation with these coefficients; raises `Refusal` where they contradict."""
    ordered: dict[tuple[str, str], float] = {}
    for first, second, coefficient in pairs:
        for name in (first, second):
            if name not in spread or spread[name].shape not in NORMAL or math.isfinite(spread[name].truncated):
                expected = "a parameter of [spread] that is normal or lognormal and not truncated"
                hint = did_you_mean(name, spread, "the spread parameters") if name not in spread else ""
                raise Refusal("cannot be correlated", got=shown(name), expected=expected, hint=hint)
        if first == second:
            raise Refusal("is correlated with itself", got=shown(first), hint="name another parameter")
        pair = _pair(first, second)
        if ordered.setdefault(pair, coefficient) != coefficient:
            raise Refusal("has two coefficients", got=" and ".join(pair), hint="leave one out")
    _add_implied(ordered)
    names = sorted({name for pair in ordered for name in pair})
    matrix = [[1.0 if a == b else ordered.get(_pair(a, b), 0.0) for b in names] for a in names]
    return Correlation(tuple((*pair, r) for pair, r in sorted(ordered.items())), tuple(names), _factor(names, matrix))


def _add_implied(ordered: dict[tuple[str, str], float]) -> None:
    """Add the correlations that follow where two parameters are fully correlated: one has those of the other."""
    names, size = {name for pair in ordered for name in pair}, 0
    while size < len(ordered):
        size = len(ordered)
        for (first, second), sign in list(ordered.items()):
            for other in sorted(names - {first, second}) if abs(sign) == 1.0 else ():
                one, two = _pair(first, other), _pair(second, other)
                for known, lacking in ((one, two), (two, one)):
                    if known in ordered:
                        ordered.setdefault(lacking, sign * ordered[known])


def _pair(first: str, second: str) -> tuple[str, str]:
    return (first, second) if first < second else (second, first)


def read_coefficient(table: Mapping[str, Any], key: str) -> float:
    """A coefficient from -1 to 1; raises `Refusal`."""
    value = read_quantity(table, key, "1")
    if not -1.0 <= value <= 1.0:
        raise Refusal("out of range", key=key, got=shown(table[key]), expected="a number from -1 to 1")
    return value


def _factor(names: Sequence[str], matrix: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], ...]:
    """The lower triangle of Cholesky; raises `Refusal` where the matrix has a negative eigenvalue.

    A pivot of zero is a parameter that follows from those before it: its column is zero.
    """
    rows: list[list[float]] = []
    for i in range(len(names)):
        row: list[float] = []
        for j in range(i):
            rest = matrix[i][j] - sum(row[k] * rows[j][k] for k in range(j))
            if rows[j][j] == 0.0 and abs(rest) > _ROUNDING:
                raise _contradiction(names[: i + 1])
            row.append(rest / rows[j][j] if rows[j][j] else 0.0)
        rest = matrix[i][i] - sum(entry * entry for entry in row)
        if rest < -_ROUNDING:
            raise _contradiction(names[: i + 1])
        rows.append([*row, math.sqrt(rest) if rest > _ROUNDING else 0.0])
    return tuple(map(tuple, rows))


def _contradiction(names: Sequence[str]) -> Refusal:
    message = "the correlations contradict each other: their matrix is not positive definite"
    return Refusal(message, got=f"of {', '.join(names)}", hint=f"make those of {names[-1]} smaller")
