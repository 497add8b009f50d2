"""Python values within a program: numbers, arrays, tuples and NamedTuples of them, and values known beforehand.

A NamedTuple of the program is a Python NamedTuple with values of the program in its fields.
Functions, classes, modules and None are not values of a program: they are known when a function is
lowered, and are part of its key.
"""

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import Any, TypeAlias

from proofmass.blocks.language.values import is_record
from proofmass.runner.program.form import Function, Immediate, Kind, Storage, Value, Variable

Lowered: TypeAlias = Any  # Operand | Array | tuple of Lowered | what is known
_LEAVES = Value | Immediate | Storage | Variable | Kind  # the last in place of numbers, in the form of a result


def is_scalar(value: Lowered) -> bool:
    """Return whether a value is a number or truth value."""
    return isinstance(value, Value | Immediate)


def leaves(value: Lowered) -> Iterator[Any]:
    """Numbers, arrays and variables of a value, in order; values known beforehand have none."""
    if isinstance(value, tuple):
        for part in value:
            yield from leaves(part)
    elif isinstance(value, _LEAVES):
        yield value


def like(value: tuple[Any, ...], parts: Iterable[Any]) -> tuple[Any, ...]:
    """Make a tuple of other parts, or a NamedTuple if the value is one."""
    make: Callable[[Iterable[Any]], tuple[Any, ...]] = getattr(type(value), "_make", tuple)
    return make(parts)


def mapped(value: Lowered, change: Callable[[Any], Any]) -> Lowered:
    """Return the same structure with its numbers, arrays and variables changed."""
    if isinstance(value, tuple):
        return like(value, [mapped(part, change) for part in value])
    return change(value) if isinstance(value, _LEAVES) else value


def rebuilt(shape: Lowered, parts: Iterable[Any]) -> Lowered:
    """Return the same structure with other numbers, in their order."""
    left = iter(parts)
    return mapped(shape, lambda _: next(left))


def named(value: tuple[Lowered, ...]) -> list[tuple[str, Lowered]]:
    """The parts of a tuple with the names that readers know them by."""
    return list(zip(map(str, getattr(value, "_fields", range(len(value)))), value, strict=True))


def shape_of(value: Lowered) -> Hashable:
    """Key by which a function is lowered: the same for arguments of one structure and kinds."""
    if isinstance(value, tuple):
        return type(value), tuple(map(shape_of, value))
    if isinstance(value, Value | Immediate):
        return value.kind
    if isinstance(value, Storage):
        return Storage, value.entry, value.length, value.writable
    return _Known(value)


def has_functions(value: Lowered) -> bool:
    """Return whether a value contains functions of a program."""
    return any(map(has_functions, value)) if isinstance(value, tuple) else isinstance(value, Function)


class _Known:
    """A value known beforehand; equal to the same object alone."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Known) and other.value is self.value

    def __hash__(self) -> int:
        return id(self.value)


def described(shape: Hashable) -> str:
    """A shape as text that is the same in every process."""
    if isinstance(shape, tuple):
        return f"({', '.join(map(described, shape))})"
    if isinstance(shape, _Known):
        value = shape.value
        if isinstance(value, Function):
            return value.name
        return f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', repr(value))}"
    if isinstance(shape, Kind):
        return shape.value
    return f"{shape.__module__}.{shape.__qualname__}" if isinstance(shape, type) else repr(shape)


def in_words(value: Lowered) -> str:
    """Return the type of a value in words, for refusals."""
    if is_scalar(value):
        return {Kind.FLOAT: "a number", Kind.INTEGER: "an integer", Kind.TRUTH: "a truth value"}[value.kind]
    if isinstance(value, Storage):
        return "a list of values"
    if isinstance(value, tuple):
        return f"a {type(value).__name__}" if is_record(type(value)) else f"a tuple of {len(value)}"
    return f"the {type(value).__name__} {getattr(value, '__name__', '')}".strip()
