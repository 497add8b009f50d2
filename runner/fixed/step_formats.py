"""Formats of the arguments and results of a step function: how its numbers lie in registers.

A format is `Fixed`, `int`, `Within` or `bool`. Formats stand in the place of the values: a
NamedTuple of them for a state or the constants, a tuple, or a list for a buffer that the step
updates in place. Anything else is a constant of the step, behind `SteadyValue` where it could be
mistaken for a format.
"""

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, stored


@dataclass(frozen=True)
class Within:
    """The format of an argument that is an integer from `low` to `high`; stored is what the step makes of it."""

    low: int
    high: int


Format: TypeAlias = Fixed | Within | type[int] | type[bool]
Held: TypeAlias = type[float] | type[int] | type[bool]
Formats: TypeAlias = Any  # a format, a NamedTuple, tuple or list of them, or a constant

WORD = Fixed(64)  # what the compiled loop holds an int in


@dataclass(frozen=True)
class SteadyValue:
    """Stands in the place of a format for a value that is the same whenever the step runs, a `Fixed` among them."""

    value: Any


class Cleared(list[Format]):
    """The formats of an output's entries, which begin each tick with zeros: it has no memory."""


def held_as(kind: Any) -> Held:
    """The type of the number by which engines hold a value of a type: a fixed-point value is its mantissa.

    >>> held_as(FixedValue), held_as(bool)
    (<class 'int'>, <class 'bool'>)
    """
    return int if kind is FixedValue else kind


def is_format(formats: Formats) -> bool:
    """Return whether it is the format of one number."""
    return isinstance(formats, Fixed | Within) or formats is int or formats is bool


def bounds(format: Format) -> tuple[int, int]:
    """The lowest and the highest mantissa."""
    if format is bool:
        return 0, 1
    if isinstance(format, Within):
        return format.low, format.high
    register = format if isinstance(format, Fixed) else WORD
    return register.lowest, register.highest


def leaves(formats: Formats, text: str) -> Iterator[tuple[Format, str]]:
    """Each format, and how Python reads its number from the value called `text`."""
    if is_format(formats):
        yield formats, text
    elif isinstance(formats, tuple | list):
        for each, part in zip(formats, parts(formats, text), strict=True):
            yield from leaves(each, part)


def parts(formats: Formats, text: str) -> Iterator[str]:
    """Yield the expressions that read entries of a NamedTuple, tuple or list called `text`."""
    if hasattr(formats, "_fields"):
        return (f"{text}.{name}" for name in formats._fields)
    return (f"{text}[{i}]" for i in range(len(formats)))


def mantissas(formats: Formats, raw: Any, text: str) -> Iterator[tuple[str, Any]]:
    """The mantissas of a raw value, in the order of `leaves` and with their texts."""
    if is_format(formats):
        yield text, raw
    elif isinstance(formats, tuple | list):
        for each, entry, part in zip(formats, raw, parts(formats, text), strict=True):
            yield from mantissas(each, entry, part)


def filled(formats: Formats, text: str, mantissa: Callable[[str, Format], Any]) -> Any:
    """A raw value: the formats' form, with a mantissa for each format."""
    if is_format(formats):
        return mantissa(text, formats)
    if isinstance(formats, tuple | list):
        return _maker(formats)(
            [filled(e, part, mantissa) for e, part in zip(formats, parts(formats, text), strict=True)]
        )
    return formats


def loader(formats: Formats) -> Callable[[Any], Any]:
    """Return the function that turns a raw value, with mantissas in it, into the value that a step function takes."""
    if isinstance(formats, Fixed):
        fraction = formats.fraction
        return lambda raw: FixedValue(raw, fraction)
    if is_format(formats):
        return lambda raw: raw
    if isinstance(formats, tuple | list):
        make, loaders = _maker(formats), [loader(each) for each in formats]
        if isinstance(formats, Cleared):
            return lambda raw: [load(0) for load in loaders]
        return lambda raw: make([load(entry) for load, entry in zip(loaders, raw, strict=True)])
    value = formats.value if isinstance(formats, SteadyValue) else formats
    return lambda raw: value


def storer(formats: Formats, text: str, at: Callable[[str], object] = lambda text: None) -> Callable[[Any], Any]:
    """Return the function that turns a step function's result into the raw value; `at` is told
    which number is next.

    It raises TypeError for a result of another form, OverflowError for a number outside its format.
    """
    if isinstance(formats, Fixed):
        return lambda value: at(text) or stored(value, formats)
    if is_format(formats):
        kind = int if isinstance(formats, Within) else formats
        return lambda value: at(text) or _stored_integer(kind, value)
    if isinstance(formats, tuple | list):
        make = _maker(formats)
        storers = [storer(each, part, at) for each, part in zip(formats, parts(formats, text), strict=True)]

        def store(value: Any) -> Any:
            at(text)
            if not isinstance(value, tuple | list) or len(value) != len(storers):
                raise TypeError(f"{len(storers)} values are expected, not {value!r}")
            return make([each(entry) for each, entry in zip(storers, value, strict=True)])

        return store
    return lambda value: None


def reference_step(function: Callable[..., Any], formats: Mapping[str, Formats]) -> Callable[..., Any]:
    """The step function itself on Python integers, taking and returning raw values: what compiled
    code must equal.

    Lists are changed in place. The result raises OverflowError where it does not fit its format.
    """
    names = tuple(inspect.signature(function).parameters)
    loaders = [loader(formats[name]) for name in names]
    buffers = [(i, storer(formats[name], name)) for i, name in enumerate(names) if isinstance(formats[name], list)]
    store = storer(formats.get("return"), "return")

    def step(*arguments: Any) -> Any:
        values = [load(raw) for load, raw in zip(loaders, arguments, strict=True)]
        result = store(function(*values))
        for i, store_buffer in buffers:
            arguments[i][:] = store_buffer(values[i])
        return result

    return step


def _stored_integer(format: Any, value: Any) -> Any:
    if isinstance(value, FixedValue | float):
        raise TypeError(f"a {type(value).__name__} for a number of type {format.__name__}")
    low, high = bounds(format)
    if not isinstance(value, int):
        return value.held(low, high, format.__name__)
    if not low <= value <= high:
        raise OverflowError(f"{value} is outside {low} to {high}")
    return format(value)


def _maker(formats: Formats) -> Callable[[list[Any]], Any]:
    return formats._make if hasattr(formats, "_make") else type(formats)
