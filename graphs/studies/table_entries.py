"""Entries of the tables of a study: read from texts, numbers and lists, and refused with key, value and cure."""

import math
from collections.abc import Collection, Iterator, Mapping
from fractions import Fraction
from typing import Any

from proofmass.blocks.declaration.problem import Problem, Refusal, shown, under
from proofmass.blocks.declaration.units import convert, same_dimension, split_quantity
from proofmass.graphs.model.hints import key_hint
from proofmass.graphs.model.rates import read_duration


def checked_table(table: object, keys: Mapping[str, str], example: str) -> Mapping[str, Any]:
    """A table of which all keys are known."""
    if not isinstance(table, Mapping):
        raise Refusal("must be a table", got=shown(table), hint=example)
    for key in table:
        if key not in keys:
            raise Refusal("unknown key", key=str(key), got=shown(key), hint=key_hint(str(key), keys, table))
    return table


def unknown_keys(table: Mapping[str, Any], keys: Collection[str]) -> Iterator[Problem]:
    """Yield a problem for each key of a table of a file that is not known."""
    for key in table:
        if key not in keys:
            yield Refusal("unknown key", key_hint(key, keys, table)).problem(key, key, path=(key,))


def read_flag(table: Mapping[str, Any], key: str) -> bool:
    """A switch of a table, false when nothing is said."""
    value = table.get(key, False)
    if not isinstance(value, bool):
        raise Refusal("must be true or false", key=key, got=shown(value))
    return value


def read_time(entry: object, key: str, expected: str = "") -> Fraction:
    """A duration that stands under a key."""
    with under(key, entry, expected):
        return read_duration(entry)


def read_values(values: object, key: str, unit: str) -> tuple[float, ...]:
    """A list of quantities."""
    if not isinstance(values, list | tuple) or not values:
        raise Refusal("must be a list of values", key=key, got=shown(values), hint="write a list, such as [1.0, 2.0]")
    return tuple(read_quantity({key: value}, key, unit) for value in values)


def read_quantity(table: Mapping[str, Any], key: str, unit: str, at_least: float = -math.inf) -> float:
    """A number in the unit, or a text with its own."""
    value = table[key]
    expected = f"a number in {unit}" if unit != "1" else "a number"
    expected += f" of at least {at_least:g}" if math.isfinite(at_least) else ""
    try:
        number = convert(value, unit) if isinstance(value, str) else _number(value)
    except Refusal as error:
        raise _of_a_part(error, key, value, unit).under(key, value, expected) from None
    if not math.isfinite(number) or number < at_least:
        raise Refusal("out of range", key=key, got=shown(value), expected=expected)
    return number


def _of_a_part(error: Refusal, key: str, value: object, unit: str) -> Refusal:
    """The refusal of a part, as 20 ppm, with what makes one of it: relative, and per time where an ageing is wanted."""
    part = isinstance(value, str) and _is_part(value)
    if not part or unit == "1":
        return error
    for measure, word in (("1/s", "/year"), ("1/sqrt(s)", "/sqrt(year)")):
        if same_dimension(unit, measure):
            return Refusal(str(error), f'it is per time: {key} = "{value}{word}"')
        if unit.endswith(measure.removeprefix("1")):
            return Refusal(str(error), f'relative to the value, per time: {key} = "{value}{word}", relative = true')
    return Refusal(str(error), "a part of the value of the graph needs relative = true")


def _is_part(text: str) -> bool:
    """Return whether a text is a dimensionless number with a unit such as ppm or %."""
    try:
        own = split_quantity(text)[1]
        return bool(own) and same_dimension(own, "1")
    except Refusal:
        return False


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Refusal("must be a number")
    try:
        return float(value)
    except OverflowError:
        raise Refusal("is too large for a number") from None
