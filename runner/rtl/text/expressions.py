"""Operations as Verilog expressions: numbers are signed, truth values one bit."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from proofmass.runner.fixed.integer_interval import signed_width
from proofmass.runner.fixed.integer_ir import Node
from proofmass.runner.fixed.operations import BITWISE, COMPARISONS, OPERATIONS
from proofmass.runner.rtl.machine.low_bits import is_bit, wrapped
from proofmass.runner.rtl.machine.words import Word


class Expression(NamedTuple):
    """The text of an operation. An alias needs no wire of its own; wiring takes no logic."""

    text: str
    truth: bool = False
    alias: bool = False
    wiring: bool = False


def literal(value: int) -> str:
    """A signed number, exactly as wide as it is; only -1 has a bit more, to be readable.

    >>> literal(5), literal(-5), literal(-8), literal(-1)
    ("4'sd5", "-4'sd5", "4'sh8", "-2'sd1")
    """
    return _signed(value, max(signed_width(value, value), 1 + (value == -1)))


def _signed(value: int, width: int) -> str:
    if value == -(1 << (width - 1)):
        return f"{width}'sh{1 << (width - 1):x}"  # -4'sd8 would be +8 where it stands among wider numbers
    return f"-{width}'sd{-value}" if value < 0 else f"{width}'sd{value}"


def fitted(value: int, word: Word) -> str:
    """A number for a port or register.

    >>> fitted(3, Word(0, 1023)), fitted(3, Word(-8, 7))
    ("10'd3", "4'sd3")
    """
    return _signed(value, word.width) if word.signed else f"{word.width}'d{value}"


class Expressions:
    """Expressions over the wires that have a name so far; each operand is taken at the stage of what it is for."""

    def __init__(self, stages: Mapping[Node, int]) -> None:
        self._stages = stages
        self._stage = 0  # of what is written
        self._names: dict[Node, list[str]] = {}  # as it comes, and by how many ticks later
        self._truths: set[Node] = set()

    def name(self, node: Node, names: list[str], *, truth: bool = False) -> None:
        """Call a node by names from now on: the first as it comes, the others for one tick later each."""
        self._names[node] = names
        if truth:
            self._truths.add(node)

    def stored(self, node: Node, word: Word, stage: int) -> str:
        """A node as a port or register takes it: its low bits, where it has a sign bit that they lack."""
        self._stage = stage
        if node.constant is not None:
            return fitted(node.constant, word)
        if node in self._truths or node.width <= word.width:
            return self._text(node)
        return self._bits(node, word.width - 1, 0)

    def of(self, node: Node) -> Expression:
        """The expression of an operation; of a cut, what its register takes."""
        self._stage = self._stages[node] - (node.operation == "pipe")
        kept = wrapped(node)
        if kept is not None:
            return Expression(self._bits(kept, node.width - 1, 0), wiring=True)
        first = node.operands[0]
        if node.operation == "pipe":
            return Expression(self._text(first), truth=first in self._truths)
        if node.operation == "narrow":
            return self._narrowed(first, node)
        if node.operation in COMPARISONS:
            return self._compared(node)
        if node.operation in BITWISE:
            return self._bitwise(node)
        if node.operation == "select":
            return self._selected(node)
        if node.operation in ("shift_left", "shift_right"):
            return self._shifted(node, *node.operands)
        return self._written(node, map(self._number, node.operands))

    def _written(self, node: Node, operands: Iterable[str], *, truth: bool = False) -> Expression:
        return Expression(OPERATIONS[node.operation].in_verilog(*operands), truth=truth)

    def _narrowed(self, whole: Node, node: Node) -> Expression:
        if is_bit(node):
            return Expression(self._bits(whole, 0, 0), truth=True, wiring=True)
        if node.width == whole.width:
            return Expression(self._text(whole), alias=True)
        return Expression(self._bits(whole, node.width - 1, 0), wiring=True)

    def _compared(self, node: Node) -> Expression:
        a, b = node.operands
        for truth, other in ((a, b), (b, a)):
            if truth in self._truths and other.constant in (0, 1) and node.operation in ("equal", "not_equal"):
                same = (node.operation == "equal") == (other.constant == 1)
                return Expression(f"{'' if same else '!'}{self._text(truth)}", truth=True, alias=same)
        return self._written(node, map(self._number, node.operands), truth=True)

    def _bitwise(self, node: Node) -> Expression:
        a, b = node.operands
        if all(map(is_bit, (a, b))):
            return self._written(node, map(self._truth, node.operands), truth=True)
        for number, mask in ((a, b), (b, a)):
            width = (mask.constant or 0).bit_length()
            is_mask = node.operation == "and" and mask.constant is not None and mask.constant == (1 << width) - 1
            if is_mask and width < number.width and (node.low, node.high) == (0, mask.constant):
                if width == 1:
                    return Expression(self._bits(number, 0, 0), truth=True, wiring=True)
                return Expression(f"{{1'b0, {self._bits(number, width - 1, 0)}}}", wiring=True)
        return self._written(node, map(self._number, node.operands))

    def _selected(self, node: Node) -> Expression:
        condition, chosen, otherwise = node.operands
        test = self._truth(condition) if is_bit(condition) else f"({self._number(condition)} != 1'sd0)"
        if is_bit(node):
            return self._written(node, (test, self._truth(chosen), self._truth(otherwise)), truth=True)
        return self._written(node, (test, self._number(chosen), self._number(otherwise)))

    def _shifted(self, node: Node, value: Node, places: Node) -> Expression:
        if node.operation == "shift_left" or places.constant is None:
            return self._written(node, (self._number(value), self._places(places)))
        lowest = min(places.constant, value.width - 1)
        if is_bit(node):
            return Expression(self._bits(value, lowest, lowest), truth=True, wiring=True)
        return Expression(self._bits(value, lowest + node.width - 1, lowest), wiring=True)

    def _places(self, node: Node) -> str:
        """A number of places, which Verilog takes without sign."""
        return str(node.constant) if node.constant is not None else self._text(node)

    def _number(self, node: Node) -> str:
        if node.constant is not None:
            return literal(node.constant)
        name = self._text(node)
        return f"$signed({{1'b0, {name}}})" if node in self._truths else name

    def _truth(self, node: Node) -> str:
        """A node from 0 to 1 as one bit."""
        if node.constant is not None:
            return f"1'b{node.constant}"
        return self._text(node) if node in self._truths else self._bits(node, 0, 0)

    def _text(self, node: Node) -> str:
        return self._names[node][self._stage - self._stages[node]]

    def _bits(self, node: Node, high: int, low: int) -> str:
        return f"{self._text(node)}[{high}]" if high == low else f"{self._text(node)}[{high}:{low}]"
