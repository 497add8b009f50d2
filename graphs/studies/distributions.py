"""Distributions of a parameter over the sensors of a study, by the inverse of their cumulative probability.

A value is a function of one uniform deviate, so that a design may say which deviates the sensors
have. Plain arithmetic only: the bits are the same on every machine.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any

from proofmass.blocks.arithmetic.counter_random import normal_quantile
from proofmass.blocks.arithmetic.elementary import exponential
from proofmass.blocks.declaration.problem import Refusal, shown
from proofmass.graphs.studies.empirical import column_file, read_column
from proofmass.graphs.studies.table_entries import checked_table, read_flag, read_quantity, read_values

NORMAL = ("normal", "lognormal")
SHAPES = (*NORMAL, "uniform", "triangular", "values", "file")
SPREAD_KEYS = {
    "normal": "Standard deviation of a normal distribution about the value of the graph.",
    "uniform": "Half the width of a uniform distribution about the value of the graph.",
    "triangular": "Half the width of a symmetric triangular distribution about the value of the graph.",
    "lognormal": "Standard deviation of the logarithm; the value of the graph is the median.",
    "values": "List of values, each as probable as the others, or as `weights` say.",
    "weights": "How probable each of the values is, relative to the others.",
    "file": "CSV file beside the study: each of its values is as probable as the others.",
    "column": "Name of the column of that file; its head may say a unit, offset [mV].",
    "relative": "true: the width is relative to the value of the graph, 1 when no unit is said.",
    "truncated": "Nothing lies beyond so many standard deviations (normal, lognormal).",
}
LEAST_TRUNCATION = 0.1  # standard deviations
LONGEST_LIST = 1000  # values that are written out in texts
_SUITS = {"weights": "values", "column": "file"}


@dataclass(frozen=True)
class Spread:
    """The distribution of one parameter about its nominal value, in its unit (or relative)."""

    shape: str
    width: float = 0.0
    values: tuple[float, ...] = ()
    weights: tuple[float, ...] = ()
    relative: bool = False
    truncated: float = math.inf

    def at(self, nominal: float, uniform: float) -> float:
        """The value below which the part `uniform` of the sensors lies, 0 < uniform < 1."""
        if self.shape == "values":
            return self.values[self._entry(uniform)]
        if self.shape in NORMAL:
            deviate = normal_quantile(self.inside(uniform))
            return self.of_normal(nominal, max(-self.truncated, min(deviate, self.truncated)))
        if self.shape == "uniform":
            return self._about(nominal, 2.0 * uniform - 1.0)
        rest = math.sqrt(2.0 * min(uniform, 1.0 - uniform))
        return self._about(nominal, rest - 1.0 if uniform < 0.5 else 1.0 - rest)

    def inside(self, uniform: float) -> float:
        """The probability of a truncated normal distribution as one of the whole."""
        return self._tail + uniform * (1.0 - 2.0 * self._tail)

    def of_normal(self, nominal: float, deviate: float, exponential: Callable[[float], float] = exponential) -> float:
        """The value for a standard normal deviate; for the shapes that are `NORMAL`."""
        if self.shape == "lognormal":
            return nominal * exponential(self.width * deviate)
        return self._about(nominal, deviate)

    def _about(self, nominal: float, standard: float) -> float:
        deviation = self.width * standard
        return nominal * (1.0 + deviation) if self.relative else nominal + deviation

    def _entry(self, uniform: float) -> int:
        if not self.weights:
            return int(uniform * len(self.values))
        wanted = uniform * self._sums[-1]
        return next(i for i, reached in enumerate(self._sums) if wanted < reached)

    @cached_property
    def column_file(self) -> tuple[str, bytes] | None:
        """Name and content of a file for values too many for a text; None for fewer."""
        return column_file(self.values) if len(self.values) > LONGEST_LIST and not self.weights else None

    def __str__(self) -> str:
        """Return all that decides which values are drawn; too many values are named by the hash of their file."""
        return f"Spread('file', {self.column_file[0]!r})" if self.column_file else repr(self)

    @cached_property
    def _sums(self) -> tuple[float, ...]:
        return tuple(accumulate(self.weights))

    @cached_property
    def _tail(self) -> float:
        """Probability beyond the truncation on one side, by bisection."""
        low, high = 2.0**-53, 0.5
        if self.truncated >= -normal_quantile(low):
            return 0.0
        while low < (middle := 0.5 * (low + high)) < high:
            low, high = (low, middle) if normal_quantile(middle) > -self.truncated else (middle, high)
        return low


def read_spread(table: object, unit: str, folder: str = "") -> Spread:
    """Entry of `[spread]` for a parameter of the unit, files from the folder; raises `Refusal`."""
    table = checked_table(table, SPREAD_KEYS, 'write { normal = "200 ppm", relative = true }')
    given = [shape for shape in SHAPES if shape in table]
    if len(given) != 1:
        raise Refusal("needs one distribution", got=shown(table), expected=f"one of {', '.join(SHAPES)}")
    (shape,) = given
    for key, suited in _SUITS.items():
        if key in table and shape != suited:
            raise Refusal(f"{shape} has no {key}", key=key, hint="leave it out")
    relative = read_flag(table, "relative")
    truncated = math.inf
    if "truncated" in table:
        if shape not in NORMAL:
            raise Refusal(f"{shape} is bounded already", key="truncated", hint="leave it out")
        truncated = read_quantity(table, "truncated", "1", at_least=LEAST_TRUNCATION)
    if shape in ("values", "file"):
        if relative:
            raise Refusal("values are not relative", key="relative", hint="leave it out")
        if shape == "file":
            return Spread("values", values=read_column(table["file"], table.get("column"), folder, unit))
        values = read_values(table["values"], "values", unit)
        weights = _read_weights(table, len(values))
        if not weights:
            return Spread(shape, values=tuple(sorted(values)))
        possible = sorted((value, weight) for value, weight in zip(values, weights, strict=True) if weight)
        ordered, theirs = zip(*possible, strict=True)
        return Spread(shape, values=ordered, weights=theirs)
    if shape == "lognormal" and relative:
        raise Refusal("a lognormal distribution is relative always", key="relative", hint="leave it out")
    width = read_quantity(table, shape, "1" if relative or shape == "lognormal" else unit, at_least=0.0)
    return Spread(shape, width, relative=relative, truncated=truncated)


def _read_weights(table: Mapping[str, Any], count: int) -> tuple[float, ...]:
    if "weights" not in table:
        return ()
    weights = read_values(table["weights"], "weights", "1")
    if len(weights) != count or min(weights) < 0.0 or not 0.0 < sum(weights) < math.inf:
        expected = f"{count} numbers of at least 0, not all 0"
        raise Refusal("must suit the values", key="weights", got=shown(table["weights"]), expected=expected)
    return weights
