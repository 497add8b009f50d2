"""A traced step as straight-line Python over 64-bit integers, which programs take in as it stands.

The code takes and returns what the step function does, with mantissas in the place of fixed-point values: a drop-in
for it in the compiled loop. Each line ends with the line of Python that it comes from. A value that 64 bits do not
hold is refused, never wrapped.
"""

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from proofmass.blocks.declaration.source import define
from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.fixed.integer_ir import Operation, SourceLine, TraceError
from proofmass.runner.fixed.operations import OPERATIONS, interval_of
from proofmass.runner.fixed.step_formats import Formats, is_format, leaves, parts
from proofmass.runner.fixed.trace import Traced, trace

LOWEST, HIGHEST = -(1 << 63), (1 << 63) - 1


class CompiledStep(NamedTuple):
    """Source of a step over integers, and the function that it defines: plain Python."""

    source: str
    function: Callable[..., Any]


def compile_step(
    function: Callable[..., Any],
    formats: Mapping[str, Formats],
    *,
    count_overflows: bool = False,
    name: str = "",
) -> CompiledStep:
    """A step function as integer code; with `count_overflows` it returns (result, casts that saturated or wrapped).

    `formats` has an entry for every argument, and "return". Raises `TraceError`.
    """
    traced = trace(function, formats)
    return compile_traced(traced, name or function.__name__, (traced.overflows,) if count_overflows else ())


def compile_traced(traced: Traced, name: str, beside: Sequence[Operation] = ()) -> CompiledStep:
    """A traced step as integer code; with `beside` it returns (result, value of each of these operations...)."""
    places: list[SourceLine | None] = []
    source = integer_source(traced, name, beside, places)
    namespace: dict[str, Any] = {kind.__name__: kind for kind in _classes(traced.formats.get("return"))}
    namespace["__name__"] = "integer_code"
    tree = ast.parse(source).body[0]
    assert isinstance(tree, ast.FunctionDef)
    for statement, place in zip(tree.body, places, strict=False):
        statement.place = place  # type: ignore[attr-defined]
    return CompiledStep(source, define(tree, f"<integer code of {name}>", namespace))


def integer_source(
    traced: Traced, name: str, beside: Sequence[Operation] = (), places: list[SourceLine | None] | None = None
) -> str:
    """The source text of a traced step; `places` gets the line of Python that each of its lines comes from."""
    live = traced.program.live([*traced.results.values(), *traced.writes.values(), *beside])
    writer = _Writer(_clamped(live, traced.name), _bools(traced.formats), traced.arguments)
    lines = list(writer.lines(live))
    if places is not None:
        places += writer.places
    for text, operation in traced.writes.items():
        if not (operation.kind == "input" and operation.name == text):
            lines.append(f"{text} = {writer.returned(text, operation)}")
    returned = _result(
        traced.formats.get("return"), "return", {t: writer.returned(t, n) for t, n in traced.results.items()}
    )
    returned = ", ".join([returned, *(writer.text[operation] for operation in beside)])
    if returned != "None":
        lines.append(f"return {returned}")
    body = "\n".join(f"    {line}" for line in lines or ["pass"])
    return f"def {name}({', '.join(traced.arguments)}):\n{body}\n"


class _Writer:
    """Names and expressions of the operations."""

    def __init__(self, clamped: set[Operation], bools: set[str], arguments: Sequence[str]) -> None:
        self.text: dict[Operation, str] = {}
        self.places: list[SourceLine | None] = []  # of the lines
        self._prefix = "v"
        while any(argument.startswith(self._prefix) for argument in arguments):
            self._prefix += "_"
        self._clamped, self._bools = clamped, bools
        self._names: dict[str, str] = {}  # of expressions already there
        self._conditions: dict[Operation, str] = {}

    def lines(self, live: list[Operation]) -> Iterator[str]:
        """One line per operation that needs a name."""
        for operation in live:
            if operation.kind == "constant":
                self.text[operation] = str(operation.low) if operation.low >= 0 else f"({operation.low})"
            elif operation.name.isidentifier() and operation.name not in self._bools:
                self.text[operation] = operation.name
            elif operation.kind == "pipe" or (operation.kind == "narrow" and operation not in self._clamped):
                self.text[operation] = self.text[operation.operands[0]]
            else:
                expression = self._expression(operation)
                if expression not in self._names:
                    self._names[expression] = f"{self._prefix}{len(self._names)}"
                    comment = f"  # {operation.place}" if operation.operands and operation.place else ""
                    self.places.append(operation.place if operation.operands else None)
                    yield f"{self._names[expression]} = {expression}{comment}"
                self.text[operation] = self._names[expression]

    def returned(self, text: str, operation: Operation) -> str:
        """A result: a truth value where the format says so."""
        return f"{self.text[operation]} != 0" if text in self._bools else self.text[operation]

    def _expression(self, operation: Operation) -> str:
        kind = operation.kind
        if kind == "input":
            return f"1 if {operation.name} else 0" if operation.name in self._bools else operation.name
        texts = [self.text[operand] for operand in operation.operands]
        if kind == "narrow":
            low, high, (value,) = operation.low, operation.high, texts
            return f"{low} if {value} < {low} else ({high} if {value} > {high} else {value})"
        if kind == "select":
            texts[0] = self._conditions.get(operation.operands[0], f"{texts[0]} != 0")
        if kind == "shift_right" and operation.operands[1].low > 63:
            texts[1] = "63"  # the sign alone is left, and a machine shifts by at most 63
        expression = OPERATIONS[kind].python.format(*texts)
        if OPERATIONS[kind].comparison:
            self._conditions[operation] = expression
            return f"1 if {expression} else 0"
        return expression


def _clamped(live: list[Operation], name: str) -> set[Operation]:
    """The narrowed operations that must be clamped in the code, so that no 64-bit operation overflows.

    Straight-line code computes the values of branches that are not taken, too, where what the branch's condition says
    does not hold; and an overflow is undefined in compiled code even where its result is not used. So intervals are
    made again without those conditions, and where one leaves 64 bits the conditions that it needs are enforced.
    """
    clamped: set[Operation] = set()
    while True:
        always: dict[Operation, Interval] = {}
        enforced = len(clamped)
        for operation in live:
            always[operation] = _unconditional(operation, always, clamped)
            low, high = always[operation]
            if low < LOWEST or high > HIGHEST or _shifts_too_far(operation, always):
                needed = {n for n in _above(operation) if n.kind == "narrow" and always[n] != (n.low, n.high)}
                if not needed:
                    _refuse(operation, name)
                clamped |= needed
                break
        if len(clamped) == enforced:
            return clamped


def _unconditional(operation: Operation, always: dict[Operation, Interval], clamped: set[Operation]) -> Interval:
    if not operation.operands or operation in clamped:
        return operation.low, operation.high
    operands = [always[operand] for operand in operation.operands]
    if operation.kind in ("shift_left", "shift_right"):  # a negative number of places is seen to by the caller
        operands[1] = max(operands[1][0], 0), max(operands[1][1], 0)
        if operands[1][1] > 1024:
            operands[1] = operands[1][0], 1024
    return interval_of(operation.kind, operands)


def _shifts_too_far(operation: Operation, always: dict[Operation, Interval]) -> bool:
    if operation.kind not in ("shift_left", "shift_right"):
        return False
    low, high = always[operation.operands[1]]
    constant_right = operation.kind == "shift_right" and operation.operands[1].constant is not None
    return low < 0 or (high > 63 and not constant_right)


def _above(operation: Operation) -> set[Operation]:
    above: set[Operation] = set()
    todo = list(operation.operands)
    while todo:
        each = todo.pop()
        if each not in above:
            above.add(each)
            todo += each.operands
    return above


def _refuse(operation: Operation, name: str) -> None:
    got = f"[{operation.low}, {operation.high}], {operation.width} bits"
    if operation.low >= LOWEST and operation.high <= HIGHEST:
        places = operation.operands[1]
        got = f"a shift by {places.low} to {places.high} places"
    hint = "round or clip the operands with .to(format) before, or take narrower formats"
    message = f"the {operation.kind.replace('_', ' ')} is wider than the 64 bits of compiled code"
    raise TraceError(message, operation.place, got=got, expected=f"[{LOWEST}, {HIGHEST}], 64 bits", hint=hint, key=name)


def _result(formats: Formats, text: str, returned: Mapping[str, str]) -> str:
    if is_format(formats):
        return returned[text]
    if not isinstance(formats, tuple | list):
        return "None"
    entries = [_result(each, part, returned) for each, part in zip(formats, parts(formats, text), strict=True)]
    if hasattr(formats, "_fields"):
        return f"{type(formats).__name__}({', '.join(entries)})"
    return f"({', '.join(entries)}{',' if len(entries) == 1 else ''})"


def _classes(formats: Formats) -> Iterator[type]:
    """The NamedTuples of a result."""
    if isinstance(formats, tuple | list):
        if hasattr(formats, "_fields"):
            yield type(formats)
        for each in formats:
            yield from _classes(each)


def _bools(formats: Mapping[str, Formats]) -> set[str]:
    return {text for name, each in formats.items() for format, text in leaves(each, name) if format is bool}
