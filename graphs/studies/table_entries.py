"""Entries of the tables of a study: read from texts, numbers and lists, and refused with key, value and cure."""

import math
from collections.abc import Mapping
from typing import Any

from proofmass.blocks.declaration.problem import shown
from proofmass.blocks.declaration.units import UnitError, convert
from proofmass.graphs.model.hints import like


class TableError(ValueError):
    """Why an entry of a study is refused: the key, what was got and expected, how to cure it."""

    def __init__(self, message: str, key: str = "", got: str = "", expected: str = "", hint: str = "") -> None:
        super().__init__(message)
        self.key, self.got, self.expected, self.hint = key, got, expected, hint


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
