"""Types of the values in a block's functions: numbers, tuples, records, vectors of the runner."""

import types
import typing
from dataclasses import dataclass
from typing import Any, TypeAlias

from proofmass.blocks.arithmetic.fixed_point import FixedValue


@dataclass(frozen=True)
class TupleOf:
    """A tuple of known length, each entry of a type of its own."""

    entries: tuple["Type", ...]


@dataclass(frozen=True)
class ListOf:
    """A tuple whose length is that of a parameter."""

    entry: "Type"


@dataclass(frozen=True)
class Vector:
    """A buffer, or a wire with a shape; `out` and the buffers of an update are written to."""

    entry: "Type"
    writable: bool
    cleared: bool = False  # as a tick begins


@dataclass(frozen=True)
class Record:
    """A NamedTuple."""

    kind: Any

    @property
    def fields(self) -> dict[str, "Type"]:
        """The types of its fields."""
        return {name: type_of(kind) for name, kind in self.kind.__annotations__.items()}


@dataclass(frozen=True)
class Meta:
    """A function, class or module: it can be called or has members, but is not a value."""

    value: Any

    def __hash__(self) -> int:
        return id(self.value)


@dataclass(frozen=True)
class RefusedType:
    """Type of an expression that was refused already: no further refusal follows from it."""


Type: TypeAlias = (
    type[int] | type[float] | type[bool] | type[None] | TupleOf | ListOf | Vector | Record | Meta | RefusedType
)
NUMBERS: tuple[Any, ...] = (int, float, bool)
NOTHING: Any = type(None)


def type_of(annotation: Any) -> Type:
    """Return the type of an annotation."""
    if annotation is FixedValue:
        return int
    if annotation is None or annotation is NOTHING:
        return NOTHING  # type: ignore[no-any-return]
    if annotation in NUMBERS:
        return annotation  # type: ignore[no-any-return]
    if typing.get_origin(annotation) is tuple:
        entries = typing.get_args(annotation)
        if len(entries) == 2 and entries[1] is Ellipsis:
            return ListOf(type_of(entries[0]))
        return TupleOf(tuple(map(type_of, entries)))
    if annotation is tuple:
        return ListOf(float)
    if is_record(annotation):
        return Record(annotation)
    return RefusedType()


def annotated(function: types.FunctionType) -> Type | None:
    """Return the declared type of a function's result; None if it declares none."""
    declared = function.__annotations__.get("return", RefusedType)
    if isinstance(declared, str):
        try:
            declared = typing.get_type_hints(function)["return"]
        except (NameError, TypeError, AttributeError):
            return None
    kind = type_of(declared)
    return None if isinstance(kind, RefusedType) else kind


def is_record(kind: Any) -> bool:
    """Return whether it is a NamedTuple."""
    return isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields")


def entry_of(kind: Type) -> Type | None:
    """Return the common type of all entries; None if there is none."""
    if isinstance(kind, ListOf | Vector):
        return kind.entry
    if isinstance(kind, TupleOf) and kind.entries and all(entry == kind.entries[0] for entry in kind.entries):
        return kind.entries[0]
    return None


def described(kind: Type) -> str:
    """Return a type in words."""
    match kind:
        case TupleOf(entries):
            return f"a tuple of {len(entries)}"
        case ListOf() | Vector():
            return "a list of values"
        case Record(named):
            return f"a {named.__name__}"
        case Meta(value):
            return f"the {type(value).__name__} {getattr(value, '__name__', '')}".strip()
        case RefusedType():
            return "unknown"
    words: dict[Any, str] = {int: "an integer", float: "a number", bool: "true or false"}
    return words.get(kind, "nothing")
