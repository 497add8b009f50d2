"""Integer code of digital blocks, written into a program: mantissas are integers, each operation is one of them."""

import hashlib
from collections.abc import Iterator, Sequence
from typing import Any

from proofmass.runner.fixed.integer_code import IntegerCode
from proofmass.runner.fixed.integer_ir import Operation
from proofmass.runner.fixed.step_formats import Formats, filled, is_format, parts
from proofmass.runner.program.build import Builder, operand, parameters_like
from proofmass.runner.program.form import INTEGER, TRUTH, Function, Line, Operand, Storage
from proofmass.runner.program.lower_numbers import as_kind
from proofmass.runner.program.structure import Lowered, described, leaves, shape_of

_WITHOUT_KIND = ("and", "or", "xor", "shift_left", "shift_right")  # others are named after the kind of their operands


def call_step(
    builder: Builder,
    code: IntegerCode,
    arguments: Sequence[Lowered],
    dropping: Function | None = None,
    resting: Function | None = None,
) -> tuple[Lowered, Sequence[Operand]]:
    """Call a step with raw values: its result, and the values of the operations beside it.

    What a shift drops passes through a function that is `dropping`: of the result, what was
    rounded, by how many places, and the code of what drops. What a search leaves over passes through
    one that is `resting`: 0, the part, the whole and the scale.
    """
    given = tuple(arguments)
    name = _name(code, given)
    if name not in builder.lowered:  # like steps share one function
        builder.lowered[name] = _Writer(name, code, given, dropping, resting).function()
    results = builder.call(builder.lowered[name], *leaves(given))
    left = iter(results)
    result = filled(code.traced.formats.get("return"), "return", lambda text, format: next(left))
    return result, list(left)


def _name(code: IntegerCode, arguments: tuple[Lowered, ...]) -> str:
    """A name that only the same operations on like arguments have."""
    traced, number = code.traced, {operation: str(i) for i, operation in enumerate(code.live)}
    content = [described(shape_of(arguments)), *(number[operation] for operation in code.beside)]
    for operation in code.live:
        read = " ".join(number[each] for each in operation.operands)
        bounds = (operation.low, operation.high, operation in code.clamped)
        content.append(f"{operation.kind} {operation.name} {bounds} {read}")
    for text, operation in (*traced.results.items(), *traced.writes.items()):
        content.append(f"{text} {number[operation]}")
    return f"{traced.name}_{hashlib.sha256(chr(0).join(content).encode()).hexdigest()[:12]}"


class _Writer:
    """Writes one step as a function."""

    def __init__(
        self,
        name: str,
        code: IntegerCode,
        arguments: tuple[Lowered, ...],
        dropping: Function | None,
        resting: Function | None,
    ) -> None:
        self.code, self.traced, self.dropping, self.resting = code, code.traced, dropping, resting
        self.builder = Builder(name, f"integer code of {code.traced.name}", inline=True)
        self.places: dict[str, Any] = {}  # arguments by the texts of inputs; an entry of a buffer with its number
        for name, value in zip(self.traced.arguments, arguments, strict=True):
            held = parameters_like(self.builder, name, value)
            self.places |= _places(self.traced.formats[name], held, name)
        self.values: dict[Operation, Operand] = {}  # truth values among them

    def function(self) -> Function:
        """The function: reads, operations, writes, results."""
        for operation in self.code.live:
            place = operation.place if operation.operands else None
            self.builder.line = Line(place.path, place.line) if place else None
            self.values[operation] = self._value(operation)
        for text, operation in self.traced.writes.items():
            if not (operation.kind == "input" and operation.name == text):
                array, number = self.places[text]
                self.builder.store(array, number, as_kind(self.builder, self.values[operation], array.entry))
        formats = self.traced.formats.get("return")
        results = filled(
            formats, "return", lambda text, of: (self._truth if of is bool else self._whole)(self.traced.results[text])
        )
        numbers: Iterator[Any] = leaves((results,))
        self.builder.give(*numbers, *map(self._whole, self.code.beside))
        return self.builder.function()

    def _whole(self, operation: Operation) -> Operand:
        return as_kind(self.builder, self.values[operation], INTEGER)

    def _truth(self, operation: Operation) -> Operand:
        return as_kind(self.builder, self.values[operation], TRUTH)

    def _value(self, operation: Operation) -> Operand:
        kind, compute = operation.kind, self.builder.compute
        if kind == "constant":
            return operand(operation.low)
        if kind == "input":
            held = self.places[operation.name]
            return self.builder.load(*held) if isinstance(held, tuple) else held
        if kind == "pipe" or (kind == "narrow" and operation not in self.code.clamped):
            return self.values[operation.operands[0]]
        if kind == "select":
            condition, chosen, otherwise = operation.operands
            return compute("select", self._truth(condition), self._whole(chosen), self._whole(otherwise))
        a, *others = map(self._whole, operation.operands)
        if kind == "narrow":
            high = compute("select", compute("less_integers", operation.high, a), operation.high, a)
            return compute("select", compute("less_integers", a, operation.low), operation.low, high)
        if kind == "negate":
            return compute("subtract_integers", 0, a)
        if kind == "rest":
            assert self.resting is not None
            return self.builder.call(self.resting, 0, a, *others)[0]
        (b,) = others
        if kind in ("minimum", "maximum"):
            pair = (a, b) if kind == "minimum" else (b, a)
            return compute("select", compute("less_integers", *pair), a, b)
        if kind == "shift_right" and operation.operands[1].low > 63:
            b = operand(63)  # the sign alone is left, and a machine shifts by at most 63
        if self.dropping is not None and operation in self.traced.program.errors:
            drop, number = self.traced.program.errors[operation]
            number = number.operands[0] if number.kind == "narrow" else number
            given = compute("shift_right", a, b), self._whole(number), b, float(drop.code)
            return self.builder.call(self.dropping, *given)[0]
        return compute(kind if kind in _WITHOUT_KIND else f"{kind}_integers", a, b)


def _places(formats: Formats, value: Any, text: str) -> dict[str, Any]:
    """The numbers of an argument by the texts that the trace has for them; what is constant there may be left out."""
    if is_format(formats):
        return {text: value}
    places: dict[str, Any] = {}
    for number, part in enumerate(parts(formats, text) if isinstance(formats, tuple | list) else ()):
        if isinstance(value, Storage):
            places[part] = value, number
        else:
            names = getattr(formats, "_fields", None)
            held = getattr(value, names[number], None) if names else value[number]
            places |= _places(formats[number], held, part)
    return places
