"""Places of the numbers that a run and the loop exchange, by key."""

import typing
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeVar

from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.keys import ConstantOf, DuplicateKeyError, Given, Moving, ParameterOf

K = TypeVar("K", bound=Given | Moving)
FLOATS, INTEGERS = "numbers", "integers"


@dataclass
class Slots(Generic[K]):
    """Numbers in two arrays, one of floats and one of integers; truth values count as integers."""

    kinds: dict[K, tuple[type, int]] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=lambda: {FLOATS: 0, INTEGERS: 0})

    def add(self, key: K, kind: type) -> tuple[str, int]:
        """Add a place for a number; return its array and index. Raises `DuplicateKeyError`."""
        if key in self.kinds:
            raise DuplicateKeyError(key)
        name = array_of(kind)
        self.kinds[key] = (kind, self.counts[name])
        self.counts[name] += 1
        return name, self.kinds[key][1]


def array_of(kind: type) -> str:
    """The array that holds numbers of a type."""
    return FLOATS if kind is float else INTEGERS


def fields(record: Any) -> list[tuple[str, Any]]:
    """The fields of a NamedTuple with their types."""
    return list(record.__annotations__.items())


def parts(key: Given, kind: Any, values: tuple[Any, ...]) -> list[tuple[ConstantOf | ParameterOf, Any, Any]]:
    """The entries of a tuple among constants or parameters, each with its key and type."""
    assert isinstance(key, ConstantOf | ParameterOf)
    kinds = typing.get_args(kind) or ((float,) if kind is tuple else (kind,))
    kinds = kinds[:1] * len(values) if len(kinds) < 2 or kinds[1] is Ellipsis else kinds
    entries = zip(kinds, values, strict=True)
    return [(replace(key, entries=(*key.entries, i)), held_as(of), value) for i, (of, value) in enumerate(entries)]


def numbers_of(record: Any, key_of: Callable[[str], ConstantOf | ParameterOf]) -> dict[Given, Any]:
    """The numbers of constants by their keys, tuples among them by their entries."""
    numbers = dict[Given, Any]()
    left = [(key_of(f), kind, v) for (f, kind), v in zip(fields(type(record)), record, strict=True)]
    while left:
        key, kind, value = left.pop()
        if isinstance(value, tuple):
            left += parts(key, kind, value)
        else:
            numbers[key] = value
    return numbers
