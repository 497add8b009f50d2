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
from proofmass.runner.fixed.integer_ir import Node, Place, TraceError
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


def compile_traced(traced: Traced, name: str, beside: Sequence[Node] = ()) -> CompiledStep:
    """A traced step as integer code; with `beside` it returns (result, value of each of these nodes...)."""
    places: list[Place | None] = []
    source = integer_source(traced, name, beside, places)
    namespace: dict[str, Any] = {kind.__name__: kind for kind in _classes(traced.formats.get("return"))}
    namespace["__name__"] = "integer_code"
    tree = ast.parse(source).body[0]
    assert isinstance(tree, ast.FunctionDef)
    for statement, place in zip(tree.body, places, strict=False):
        statement.place = place  # type: ignore[attr-defined]
    return CompiledStep(source, define(tree, f"<integer code of {name}>", namespace))


def integer_source(
    traced: Traced, name: str, beside: Sequence[Node] = (), places: list[Place | None] | None = None
) -> str:
    """The source text of a traced step; `places` gets the line of Python that each of its lines comes from."""
    live = traced.program.live([*traced.results.values(), *traced.writes.values(), *beside])
    writer = _Writer(_clamped(live, traced.name), _bools(traced.formats), traced.arguments)
    lines = list(writer.lines(live))
    if places is not None:
        places += writer.places
    for text, node in traced.writes.items():
        if not (node.operation == "input" and node.name == text):
            lines.append(f"{text} = {writer.returned(text, node)}")
    returned = _result(
        traced.formats.get("return"), "return", {t: writer.returned(t, n) for t, n in traced.results.items()}
    )
    returned = ", ".join([returned, *(writer.text[node] for node in beside)])
    if returned != "None":
        lines.append(f"return {returned}")
    body = "\n".join(f"    {line}" for line in lines or ["pass"])
    return f"def {name}({', '.join(traced.arguments)}):\n{body}\n"


class _Writer:
    """Names and expressions of the nodes."""

    def __init__(self, clamped: set[Node], bools: set[str], arguments: Sequence[str]) -> None:
        self.text: dict[Node, str] = {}
        self.places: list[Place | None] = []  # of the lines
        self._prefix = "v"
        while any(argument.startswith(self._prefix) for argument in arguments):
            self._prefix += "_"
        self._clamped, self._bools = clamped, bools
        self._names: dict[str, str] = {}  # of expressions already there
        self._conditions: dict[Node, str] = {}

    def lines(self, live: list[Node]) -> Iterator[str]:
        """One line per node that needs a name."""
        for node in live:
            if node.operation == "constant":
                self.text[node] = str(node.low) if node.low >= 0 else f"({node.low})"
            elif node.name.isidentifier() and node.name not in self._bools:
                self.text[node] = node.name
            elif node.operation == "pipe" or (node.operation == "narrow" and node not in self._clamped):
                self.text[node] = self.text[node.operands[0]]
            else:
                expression = self._expression(node)
                if expression not in self._names:
                    self._names[expression] = f"{self._prefix}{len(self._names)}"
                    comment = f"  # {node.place}" if node.operands and node.place else ""
                    self.places.append(node.place if node.operands else None)
                    yield f"{self._names[expression]} = {expression}{comment}"
                self.text[node] = self._names[expression]

    def returned(self, text: str, node: Node) -> str:
        """A result: a truth value where the format says so."""
        return f"{self.text[node]} != 0" if text in self._bools else self.text[node]

    def _expression(self, node: Node) -> str:
        operation = node.operation
        if operation == "input":
            return f"1 if {node.name} else 0" if node.name in self._bools else node.name
        texts = [self.text[operand] for operand in node.operands]
        if operation == "narrow":
            return (
                f"{node.low} if {texts[0]} < {node.low} else ({node.high} if {texts[0]} > {node.high} else {texts[0]})"
            )
        if operation == "select":
            texts[0] = self._conditions.get(node.operands[0], f"{texts[0]} != 0")
        if operation == "shift_right" and node.operands[1].low > 63:
            texts[1] = "63"  # the sign alone is left, and a machine shifts by at most 63
        expression = OPERATIONS[operation].python.format(*texts)
        if OPERATIONS[operation].comparison:
            self._conditions[node] = expression
            return f"1 if {expression} else 0"
        return expression


def _clamped(live: list[Node], name: str) -> set[Node]:
    """The narrowed nodes that must be clamped in the code, so that no 64-bit operation overflows.

    Straight-line code computes the values of branches that are not taken, too, where what the branch's condition says
    does not hold; and an overflow is undefined in compiled code even where its result is not used. So intervals are
    made again without those conditions, and where one leaves 64 bits the conditions that it needs are enforced.
    """
    clamped: set[Node] = set()
    while True:
        always: dict[Node, Interval] = {}
        enforced = len(clamped)
        for node in live:
            always[node] = _unconditional(node, always, clamped)
            low, high = always[node]
            if low < LOWEST or high > HIGHEST or _shifts_too_far(node, always):
                needed = {n for n in _above(node) if n.operation == "narrow" and always[n] != (n.low, n.high)}
                if not needed:
                    _refuse(node, name)
                clamped |= needed
                break
        if len(clamped) == enforced:
            return clamped


def _unconditional(node: Node, always: dict[Node, Interval], clamped: set[Node]) -> Interval:
    if not node.operands or node in clamped:
        return node.low, node.high
    operands = [always[operand] for operand in node.operands]
    if node.operation in ("shift_left", "shift_right"):  # a negative number of places is seen to by the caller
        operands[1] = max(operands[1][0], 0), max(operands[1][1], 0)
        if operands[1][1] > 1024:
            operands[1] = operands[1][0], 1024
    return interval_of(node.operation, operands)


def _shifts_too_far(node: Node, always: dict[Node, Interval]) -> bool:
    if node.operation not in ("shift_left", "shift_right"):
        return False
    low, high = always[node.operands[1]]
    constant_right = node.operation == "shift_right" and node.operands[1].constant is not None
    return low < 0 or (high > 63 and not constant_right)


def _above(node: Node) -> set[Node]:
    found: set[Node] = set()
    todo = list(node.operands)
    while todo:
        each = todo.pop()
        if each not in found:
            found.add(each)
            todo += each.operands
    return found


def _refuse(node: Node, name: str) -> None:
    got = f"[{node.low}, {node.high}], {node.width} bits"
    if node.low >= LOWEST and node.high <= HIGHEST:
        places = node.operands[1]
        got = f"a shift by {places.low} to {places.high} places"
    hint = "round or clip the operands with .to(format) before, or take narrower formats"
    message = f"the {node.operation.replace('_', ' ')} is wider than the 64 bits of compiled code"
    raise TraceError(message, node.place, got=got, expected=f"[{LOWEST}, {HIGHEST}], 64 bits", hint=hint, key=name)


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
