"""Operations as Verilog expressions: numbers are signed, truth values one bit."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from proofmass.runner.fixed.integer_interval import signed_width
from proofmass.runner.fixed.integer_ir import Operation
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
        return f"{width}'sh{1 << (width - 1):x}"  # -4'sd8 would be +8 among wider numbers
    return f"-{width}'sd{-value}" if value < 0 else f"{width}'sd{value}"


def fitted(value: int, word: Word) -> str:
    """A number for a port or register.

    >>> fitted(3, Word(0, 1023)), fitted(3, Word(-8, 7))
    ("10'd3", "4'sd3")
    """
    return _signed(value, word.width) if word.signed else f"{word.width}'d{value}"


class VerilogExpressions:
    """Expressions over wires named so far; each operand is taken at the stage of its operation."""

    def __init__(self, stages: Mapping[Operation, int]) -> None:
        self._stages = stages
        self._stage = 0  # of the expression being written
        self._names: dict[Operation, list[str]] = {}  # names of an operation as it comes, and for each later tick
        self._truths: set[Operation] = set()

    def name(self, operation: Operation, names: list[str], *, truth: bool = False) -> None:
        """Call an operation by names from now on: the first as it comes, the others for one tick later each."""
        self._names[operation] = names
        if truth:
            self._truths.add(operation)

    def stored(self, operation: Operation, word: Word, stage: int) -> str:
        """Text of an operation for a port or register: its low bits if that has no sign bit."""
        self._stage = stage
        if operation.constant is not None:
            return fitted(operation.constant, word)
        if operation in self._truths or operation.width <= word.width:
            return self._text(operation)
        return self._bits(operation, word.width - 1, 0)

    def of(self, operation: Operation) -> Expression:
        """Expression of an operation; for a cut, the next value of its register."""
        self._stage = self._stages[operation] - (operation.kind == "pipe")
        kept = wrapped(operation)
        if kept is not None:
            return Expression(self._bits(kept, operation.width - 1, 0), wiring=True)
        first = operation.operands[0]
        if operation.kind == "pipe":
            return Expression(self._text(first), truth=first in self._truths)
        if operation.kind == "narrow":
            return self._narrowed(first, operation)
        if operation.kind in COMPARISONS:
            return self._compared(operation)
        if operation.kind in BITWISE:
            return self._bitwise(operation)
        if operation.kind == "select":
            return self._selected(operation)
        if operation.kind in ("shift_left", "shift_right"):
            return self._shifted(operation, *operation.operands)
        return self._written(operation, map(self._number, operation.operands))

    def _written(self, operation: Operation, operands: Iterable[str], *, truth: bool = False) -> Expression:
        return Expression(OPERATIONS[operation.kind].in_verilog(*operands), truth=truth)

    def _narrowed(self, whole: Operation, operation: Operation) -> Expression:
        if is_bit(operation):
            return Expression(self._bits(whole, 0, 0), truth=True, wiring=True)
        if operation.width == whole.width:
            return Expression(self._text(whole), alias=True)
        return Expression(self._bits(whole, operation.width - 1, 0), wiring=True)

    def _compared(self, operation: Operation) -> Expression:
        a, b = operation.operands
        for truth, other in ((a, b), (b, a)):
            if truth in self._truths and other.constant in (0, 1) and operation.kind in ("equal", "not_equal"):
                same = (operation.kind == "equal") == (other.constant == 1)
                return Expression(f"{'' if same else '!'}{self._text(truth)}", truth=True, alias=same)
        return self._written(operation, map(self._number, operation.operands), truth=True)

    def _bitwise(self, operation: Operation) -> Expression:
        a, b = operation.operands
        if all(map(is_bit, (a, b))):
            return self._written(operation, map(self._truth, operation.operands), truth=True)
        for number, mask in ((a, b), (b, a)):
            width = (mask.constant or 0).bit_length()
            is_mask = operation.kind == "and" and mask.constant is not None and mask.constant == (1 << width) - 1
            if is_mask and width < number.width and (operation.low, operation.high) == (0, mask.constant):
                if width == 1:
                    return Expression(self._bits(number, 0, 0), truth=True, wiring=True)
                return Expression(f"{{1'b0, {self._bits(number, width - 1, 0)}}}", wiring=True)
        return self._written(operation, map(self._number, operation.operands))

    def _selected(self, operation: Operation) -> Expression:
        condition, chosen, otherwise = operation.operands
        test = self._truth(condition) if is_bit(condition) else f"({self._number(condition)} != 1'sd0)"
        if is_bit(operation):
            return self._written(operation, (test, self._truth(chosen), self._truth(otherwise)), truth=True)
        return self._written(operation, (test, self._number(chosen), self._number(otherwise)))

    def _shifted(self, operation: Operation, value: Operation, places: Operation) -> Expression:
        if operation.kind == "shift_left" or places.constant is None:
            return self._written(operation, (self._number(value), self._places(places)))
        lowest = min(places.constant, value.width - 1)
        if is_bit(operation):
            return Expression(self._bits(value, lowest, lowest), truth=True, wiring=True)
        return Expression(self._bits(value, lowest + operation.width - 1, lowest), wiring=True)

    def _places(self, operation: Operation) -> str:
        """A number of places, which Verilog takes without sign."""
        return str(operation.constant) if operation.constant is not None else self._text(operation)

    def _number(self, operation: Operation) -> str:
        if operation.constant is not None:
            return literal(operation.constant)
        name = self._text(operation)
        return f"$signed({{1'b0, {name}}})" if operation in self._truths else name

    def _truth(self, operation: Operation) -> str:
        """An operation from 0 to 1 as one bit."""
        if operation.constant is not None:
            return f"1'b{operation.constant}"
        return self._text(operation) if operation in self._truths else self._bits(operation, 0, 0)

    def _text(self, operation: Operation) -> str:
        return self._names[operation][self._stage - self._stages[operation]]

    def _bits(self, operation: Operation, high: int, low: int) -> str:
        return f"{self._text(operation)}[{high}]" if high == low else f"{self._text(operation)}[{high}:{low}]"
