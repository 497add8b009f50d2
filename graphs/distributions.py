"""How a parameter is spread over the sensors of a study: distributions whose deviates are counter-based.

A deviate is a pure function of (seed, run, stream), so that runs may be drawn in any order and alone. Truncation is by
rejection: the next sample of the same stream is taken until one lies within the limit.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.counter_random import normal_deviate, uniform_deviate
from proofmass.blocks.elementary import exponential
from proofmass.blocks.problem import shown
from proofmass.blocks.units import UnitError, convert
from proofmass.graphs.hints import like

SHAPES = ("normal", "uniform", "triangular", "lognormal", "values")
SPREAD_KEYS = {
    "normal": "Standard deviation of a normal distribution about the value of the graph.",
    "uniform": "Half the width of a uniform distribution about the value of the graph.",
    "triangular": "Half the width of a symmetric triangular distribution about the value of the graph.",
    "lognormal": "Standard deviation of the logarithm; the value of the graph is the median.",
    "values": "List of values, each as probable as the others.",
    "relative": "true: the width is relative to the value of the graph, 1 when no unit is said.",
    "truncated": "Deviates beyond so many standard deviations are drawn again (normal, lognormal).",
}
LEAST_TRUNCATION = 0.1  # standard deviations: one deviate in twelve lies within


class TableError(ValueError):
    """Why an entry of a study is refused: the key, what was got and expected, how to cure it."""

    def __init__(self, message: str, key: str = "", got: str = "", expected: str = "", hint: str = "") -> None:
        super().__init__(message)
        self.key, self.got, self.expected, self.hint = key, got, expected, hint


@dataclass(frozen=True)
class Spread:
    """The distribution of one parameter about its nominal value, in its unit (or relative)."""

    shape: str
    width: float = 0.0
    values: tuple[float, ...] = ()
    relative: bool = False
    truncated: float = math.inf

    def drawn(self, nominal: float, seed: int, run: int, stream: int) -> float:
        """The value that one sensor has."""
        if self.shape == "values":
            return self.values[int(uniform_deviate(seed, run, stream, 0) * len(self.values))]
        if self.shape == "lognormal":
            return nominal * exponential(self.width * self._normal(seed, run, stream))
        deviation = self.width * self._standard(seed, run, stream)
        return nominal * (1.0 + deviation) if self.relative else nominal + deviation

    def _standard(self, seed: int, run: int, stream: int) -> float:
        """A deviate of unit width about zero."""
        if self.shape == "normal":
            return self._normal(seed, run, stream)
        first = 2.0 * uniform_deviate(seed, run, stream, 0) - 1.0
        if self.shape == "uniform":
            return first
        return 0.5 * (first + 2.0 * uniform_deviate(seed, run, stream, 1) - 1.0)

    def _normal(self, seed: int, run: int, stream: int) -> float:
        sample = 0
        deviate = normal_deviate(seed, run, stream, sample)
        while abs(deviate) > self.truncated:
            sample += 1
            deviate = normal_deviate(seed, run, stream, sample)
        return deviate


def read_spread(table: object, unit: str) -> Spread:
    """An entry of `[spread]` for a parameter of that unit; raises `TableError`."""
    table = checked_table(table, SPREAD_KEYS, 'write { normal = "200 ppm", relative = true }')
    given = [shape for shape in SHAPES if shape in table]
    if len(given) != 1:
        raise TableError("needs one distribution", got=shown(table), expected=f"one of {', '.join(SHAPES)}")
    (shape,) = given
    relative = read_flag(table, "relative")
    truncated = math.inf
    if "truncated" in table:
        if shape not in ("normal", "lognormal"):
            raise TableError(f"{shape} is bounded already", "truncated", hint="leave it out")
        truncated = read_quantity(table, "truncated", "1", at_least=LEAST_TRUNCATION)
    if shape == "values":
        if relative:
            raise TableError("values are not relative", "relative", hint="leave it out")
        return Spread(shape, values=read_values(table["values"], "values", unit))
    if shape == "lognormal" and relative:
        raise TableError("a lognormal distribution is relative always", "relative", hint="leave it out")
    width = read_quantity(table, shape, "1" if relative or shape == "lognormal" else unit, at_least=0.0)
    return Spread(shape, width, (), relative, truncated)


def checked_table(table: object, keys: Mapping[str, str], example: str) -> Mapping[str, Any]:
    """A table of which all keys are known."""
    if not isinstance(table, Mapping):
        raise TableError("must be a table", got=shown(table), hint=example)
    for key in table:
        if key not in keys:
            raise TableError("unknown key", str(key), got=shown(key), hint=like(str(key), keys, "the keys"))
    return table


def read_flag(table: Mapping[str, Any], key: str) -> bool:
    """A switch of a table, false when nothing is said."""
    value = table.get(key, False)
    if not isinstance(value, bool):
        raise TableError("must be true or false", key, got=shown(value))
    return value


def read_values(values: object, key: str, unit: str) -> tuple[float, ...]:
    """A list of quantities."""
    if not isinstance(values, list | tuple) or not values:
        raise TableError("must be a list of values", key, got=shown(values), hint=f"write {key} = [1.0, 2.0]")
    return tuple(read_quantity({key: value}, key, unit) for value in values)


def read_quantity(table: Mapping[str, Any], key: str, unit: str, at_least: float = -math.inf) -> float:
    """A number in the unit, or a text with its own."""
    value = table[key]
    expected = f"a number in {unit}" if unit != "1" else "a number"
    expected += f" of at least {at_least:g}" if math.isfinite(at_least) else ""
    try:
        number = convert(value, unit) if isinstance(value, str) else _number(value)
    except UnitError as error:
        raise TableError(str(error), key, shown(value), expected, error.hint) from None
    if not math.isfinite(number) or number < at_least:
        raise TableError("out of range", key, shown(value), expected)
    return number


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise UnitError("must be a number")
    try:
        return float(value)
    except OverflowError:
        raise UnitError("is too large for a number") from None
