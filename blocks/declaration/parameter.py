"""Parameters of a block: declared with unit, bounds, default and doc; read and checked here."""

import dataclasses
import math
import typing
from collections.abc import Mapping
from typing import Any, TypeGuard

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.decorators import declares
from proofmass.blocks.declaration.problem import Problem, Refusal, shown
from proofmass.blocks.declaration.unit_parameters import unit_to_set
from proofmass.blocks.declaration.units import convert_exactly, short_unit

LARGEST_INTEGER = 2**62  # integer arithmetic of the compiled loop has 64 bits
_KINDS = (float, int, bool, str, Fixed, tuple)


@dataclasses.dataclass(frozen=True)
class Parameter:
    """Declaration of one parameter."""

    name: str
    kind: type  # float, int, bool, str, Fixed, or tuple for a list of floats
    default: Any
    unit: str  # may name other parameters in braces: "{unit}"
    doc: str
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    choices: tuple[str, ...] = ()
    not_driven: str = ""  # why no wire may drive it, and what to take instead

    def bounds(self) -> str:
        """The bounds in words, as in `> 0 and <= 1`; empty when there are none."""
        signs = ((">", self.above), (">=", self.at_least), ("<", self.below), ("<=", self.at_most))
        return " and ".join(f"{sign} {bound:g}" for sign, bound in signs if bound is not None)

    def expected(self, unit: str) -> str:
        """Return in words what the parameter takes."""
        if self.kind is bool:
            return "true or false"
        if self.kind is str:
            return f"one of {', '.join(self.choices)}" if self.choices else "a string"
        if self.kind is Fixed:
            return 'a format such as "(16, 12)": bits in all, bits of the fraction'
        noun = {float: "a number", int: "an integer", tuple: "a list of numbers"}[self.kind]
        bounds = f" {self.bounds()}" if self.bounds() else ""
        return f"{noun}{bounds}" + (f", in {short_unit(unit)}" if unit not in ("1", "") else "")

    def read(self, value: object, unit: str) -> Any:
        """The value as the type of the parameter, strings converted to its unit.

        An array of NumPy counts as its numbers. Raises `Refusal` when the value is of the wrong
        type, not finite or out of bounds.
        """
        value = plain(value)
        if self.kind is tuple:
            if not isinstance(value, list | tuple):
                raise Refusal("must be a list of numbers")
            if not value:
                raise Refusal("must not be empty")
            return tuple(self._number(entry, unit) for entry in value)
        if self.kind is bool:
            if not isinstance(value, bool):
                raise Refusal("must be true or false")
            return value
        if self.kind is str:
            return self._text(value)
        if self.kind is Fixed:
            return _format(value)
        return self._number(value, unit)

    def _text(self, value: object) -> str:
        if not isinstance(value, str):
            raise Refusal("must be a string")
        if self.choices and value not in self.choices:
            raise Refusal("is not one of the choices")
        return value

    def _number(self, value: object, unit: str) -> float | int:
        number: float | int
        if isinstance(value, str):
            number = self._converted(value, unit)
        elif not _is_number(value):
            raise Refusal("must be a number" if self.kind is not int else "must be an integer")
        elif self.kind is int:
            if not isinstance(value, int):
                raise Refusal("must be an integer", "write it without a decimal point")
            number = value
        else:
            try:
                number = float(value)
            except OverflowError:
                raise Refusal("is too large for a number") from None
        if isinstance(number, int) and abs(number) > LARGEST_INTEGER:
            raise Refusal("is beyond 62 bits")
        if not math.isfinite(number):
            raise Refusal("must be finite")
        if not self.inside(number):
            raise Refusal(f"must be {self.bounds()}")
        return number

    def _converted(self, text: str, unit: str) -> float | int:
        if self.kind is int and not text.strip():
            raise Refusal("must be an integer", "write its digits, such as 12")
        exact = convert_exactly(text, unit)
        if self.kind is int:
            if exact.denominator != 1:
                raise Refusal("must be an integer")
            return int(exact)
        try:
            return float(exact)
        except OverflowError:
            raise Refusal("is too large for a number") from None

    def inside(self, number: float) -> bool:
        """Return whether a number is within the bounds."""
        return (
            (self.above is None or number > self.above)
            and (self.at_least is None or number >= self.at_least)
            and (self.below is None or number < self.below)
            and (self.at_most is None or number <= self.at_most)
        )


def plain(value: Any) -> Any:
    """Return a number or an array of NumPy as Python has it, anything else as it is."""
    as_list = getattr(value, "tolist", None)
    return as_list() if callable(as_list) else value


def _format(value: object) -> Fixed:
    if isinstance(value, Fixed):
        return value
    if not isinstance(value, str):
        raise Refusal("must be a format", "write it in quotes")
    try:
        return Fixed.read(value)
    except ValueError as error:
        raise Refusal(str(error)) from None


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


@declares('gain: float = param("1", "Gain of the amplifier.", default=1.0)')
def param(
    unit: str,
    doc: str,
    *,
    default: Any,
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
    at_most: float | None = None,
    choices: tuple[str, ...] = (),
    not_driven: str = "",
) -> Any:
    """Declare a parameter of a block: its unit, doc, default and bounds.

    A unit may name a string parameter of the same block in braces, as in `"{unit}"`: the block then
    works in any unit. `not_driven` keeps wires from driving it: it says why, and what to take
    instead. It belongs to each parameter whose momentary value the block applies to the time
    before, as in sin(2 pi frequency time).

    `unit` and `doc` describe it, `default` is in the unit. Bounds are `above`, `at_least`, `below`
    and `at_most`; a text has `choices`. The class then raises `TypeError` for an unknown unit, or a
    default outside its bounds.

    >>> from proofmass import Block, param
    >>> class Limit(Block):
    ...     'A limit.'
    ...
    ...     level: float = param("V", "Largest voltage.", default=1.0, above=0.0)
    >>> Limit(level="20 mV").level
    0.02
    """
    bounds = {"above": above, "at_least": at_least, "below": below, "at_most": at_most}
    more = {"bounds": bounds, "choices": choices, "not_driven": not_driven}
    return dataclasses.field(default=default, metadata={"unit": unit, "doc": doc, **more})


def declared(owner: str, name: str, field: object, annotation: Any) -> Parameter:
    """The parameter that the class `owner` declares by `param`; the values of a `Literal` are its choices."""
    metadata = field.metadata if isinstance(field, dataclasses.Field) else {}
    kind, choices = annotation, metadata.get("choices", ())
    if typing.get_origin(kind) is typing.Literal:
        kind, choices = str, typing.get_args(kind)
    if typing.get_origin(kind) is tuple:
        kind = tuple
    if not isinstance(field, dataclasses.Field) or "bounds" not in metadata or kind not in _KINDS:
        raise TypeError(f"{owner}.{name} must be float, int, bool, str, Fixed or tuple[float, ...] = param(...)")
    texts = {"unit": metadata["unit"], "doc": metadata["doc"], "not_driven": metadata["not_driven"]}
    parameter = Parameter(name, kind, field.default, choices=choices, **metadata["bounds"], **texts)
    try:
        default = field.default if kind is Fixed else parameter.read(field.default, parameter.unit)
    except Refusal as error:
        expected = parameter.expected(parameter.unit)
        raise TypeError(f"{owner}.{name}: its default {shown(field.default)} {error}; expected {expected}") from None
    return dataclasses.replace(parameter, default=default)


def read_parameters(
    parameters: Mapping[str, Parameter], written: Mapping[str, object], key: str
) -> tuple[dict[str, Any], list[Problem]]:
    """Values of all parameters, defaults filled in, and every problem among the given ones."""
    texts = {name: written.get(name, p.default) for name, p in parameters.items() if p.kind is str}
    values: dict[str, Any] = {}
    problems: list[Problem] = []
    for name, parameter in parameters.items():
        if name not in written:
            values[name] = parameter.default
            continue
        unit = fill(parameter.unit, texts)
        try:
            values[name] = parameter.read(written[name], unit)
        except Refusal as error:
            values[name] = parameter.default
            problems.append(
                Problem(
                    message=str(error),
                    key=f"{key}.{name}",
                    got=shown(written[name])
                    + (f" {short_unit(unit)}" if _is_number(written[name]) and unit not in ("1", "") else ""),
                    expected=parameter.expected(unit),
                    hint=unit_to_set(parameter.unit, written[name], texts) or error.hint,
                    path=(name,),
                )
            )
    return values, problems


def fill(template: str, values: Mapping[str, object]) -> str:
    """Return a unit with the values of the parameters that it names in braces.

    >>> fill("{output_unit}/({input_unit})", {"output_unit": "V", "input_unit": "m"})
    'V/(m)'
    """
    for name, value in values.items():
        template = template.replace("{" + name + "}", str(value))
    return template
