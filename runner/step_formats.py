"""Formats of the arguments and results of a step function: how its numbers lie in registers.

A format is `Fixed`, `int` or `bool`. Formats stand in the place of the values: a NamedTuple of them for a state or the
constants, a tuple, or a list for a buffer that the step updates in place. Anything else is a constant of the step.
"""

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from proofmass.blocks.fixed_point import Fixed, FixedValue

Format: TypeAlias = Fixed | type[int] | type[bool]
Formats: TypeAlias = Any  # a format, a NamedTuple, tuple or list of them, or a constant

WORD = Fixed(64)  # what the compiled loop holds an int in


def is_format(formats: Formats) -> bool:
    """Whether it is the format of one number."""
    return isinstance(formats, Fixed) or formats is int or formats is bool


def bounds(format: Format) -> tuple[int, int]:
    """The lowest and the highest mantissa."""
    if format is bool:
        return 0, 1
    register = format if isinstance(format, Fixed) else WORD
    return register.lowest, register.highest


def leaves(formats: Formats, text: str) -> Iterator[tuple[Format, str]]:
    """Each format, and how Python reads its number from the value called `text`."""
    if is_format(formats):
        yield formats, text
    elif isinstance(formats, tuple | list):
        for each, part in zip(formats, parts(formats, text), strict=True):
            yield from leaves(each, part)


def parts(formats: "tuple[Formats, ...] | list[Formats]", text: str) -> Iterator[str]:
    """How Python reads the entries of a NamedTuple, a tuple or a list called `text`."""
    if hasattr(formats, "_fields"):
        return (f"{text}.{name}" for name in formats._fields)
    return (f"{text}[{i}]" for i in range(len(formats)))


def loaded(formats: Formats, text: str, mantissa: Callable[[str, Format], Any]) -> Any:
    """The value that a step function gets, from the mantissas of its numbers."""
    if isinstance(formats, Fixed):
        return formats.load(mantissa(text, formats))
    if is_format(formats):
        return mantissa(text, formats)
    if isinstance(formats, list):
        return [loaded(e, t, mantissa) for e, t in zip(formats, parts(formats, text), strict=True)]
    if isinstance(formats, tuple):
        entries = [loaded(e, t, mantissa) for e, t in zip(formats, parts(formats, text), strict=True)]
        return type(formats)(*entries) if hasattr(formats, "_fields") else tuple(entries)
    return formats


def stored(formats: Formats, value: Any, text: str, at: Callable[[str], None] = lambda text: None) -> list[Any]:
    """The mantissas of a step's result, in the order of `leaves`; each must fit. `at` is told which one is next.

    Raises TypeError for a value of another form, OverflowError for a number outside its format.
    """
    at(text)
    if isinstance(formats, Fixed):
        return [formats.store(value)]
    if is_format(formats):
        if isinstance(value, FixedValue | float):
            raise TypeError(f"a {type(value).__name__} for a number of type {formats.__name__}")
        low, high = bounds(formats)
        if isinstance(value, int):
            if not low <= value <= high:
                raise OverflowError(f"{value} is outside {low} to {high}")
            return [formats(value)]
        return [value.held(low, high, formats.__name__)]
    if not isinstance(formats, tuple | list):
        return []
    if not isinstance(value, tuple | list) or len(value) != len(formats):
        raise TypeError(f"{len(formats)} values are expected, not {value!r}")
    entries = zip(formats, value, parts(formats, text), strict=True)
    return [mantissa for each, v, t in entries for mantissa in stored(each, v, t, at)]


def reference_step(function: Callable[..., Any], formats: dict[str, Formats]) -> Callable[..., Any]:
    """The step function itself on Python integers, taking and returning mantissas: what compiled code must equal.

    Lists are changed in place. Raises OverflowError where a result does not fit its format.
    """
    names = [name for name in formats if name != "return"]

    def step(*arguments: Any) -> Any:
        values = {}
        for name, argument in zip(names, arguments, strict=True):
            given = dict(_mantissas(formats[name], argument, name))
            values[name] = loaded(formats[name], name, lambda text, _, given=given: given[text])  # type: ignore[misc]
        result = function(**values)
        for name, argument in zip(names, arguments, strict=True):
            if isinstance(formats[name], list):
                argument[:] = stored(formats[name], values[name], name)
        returned = formats.get("return")
        mantissas = dict(
            zip((t for _, t in leaves(returned, "return")), stored(returned, result, "return"), strict=True)
        )
        return _raw(returned, "return", mantissas)

    return step


def _mantissas(formats: Formats, value: Any, text: str) -> Iterator[tuple[str, Any]]:
    """The mantissas of an argument, by the text of each leaf."""
    if is_format(formats):
        yield text, value
    elif isinstance(formats, tuple | list):
        for each, entry, part in zip(formats, value, parts(formats, text), strict=True):
            yield from _mantissas(each, entry, part)


def _raw(formats: Formats, text: str, mantissas: dict[str, Any]) -> Any:
    """A value of the formats' form with raw mantissas in it."""
    if is_format(formats):
        return mantissas[text]
    if not isinstance(formats, tuple | list):
        return None
    entries = [_raw(e, t, mantissas) for e, t in zip(formats, parts(formats, text), strict=True)]
    return type(formats)(*entries) if hasattr(formats, "_fields") else type(formats)(entries)
