"""Literals by the rules of Verilog, and low bits as two's complement."""

import pytest

from proofmass.blocks.arithmetic.fixed_point import Fixed, wrap
from proofmass.runner.fixed.trace import trace
from proofmass.runner.rtl.machine.low_bits import operands_of
from proofmass.runner.rtl.machine.words import Word
from proofmass.runner.rtl.text.expressions import fitted, literal
from tests.by_hand.verilog import ModuleByHand


def value_of(text: str, width: int) -> int:
    """A literal where it is assigned to a wire of some width."""
    module = f"module m (\n    output wire signed [{width - 1}:0] y\n);\n    assign y = {text};\nendmodule"
    return ModuleByHand(module).clock({})["y"]


@pytest.mark.parametrize("value", [0, 1, -1, 2, -2, 7, -7, 8, -8, 127, -128, 128, 2**40, -(2**40), 2**40 - 1])
def test_a_literal_is_its_value_in_every_width(value: int) -> None:
    for width in (42, 50, 77):
        assert value_of(literal(value), width) == value


@pytest.mark.parametrize(("low", "high"), [(0, 1), (0, 1023), (-8, 7), (-(2**31), 2**31 - 1)])
def test_a_fitted_literal_has_the_bits_of_its_word(low: int, high: int) -> None:
    word = Word(low, high)
    for value in (low, high, (low + high) // 2):
        text = fitted(value, word)
        assert int(text.lstrip("-").partition("'")[0]) == word.width
        assert value_of(text, word.width + 1) == value


def test_a_wrap_is_the_low_bits_of_the_value_itself() -> None:
    traced = trace(lambda a: wrap(a * 5, Fixed(6)), {"a": Fixed(9), "return": Fixed(6)})
    operation = traced.results["return"]
    (operand,) = operands_of(operation)
    assert (operation.kind, operand.kind) == ("subtract", "multiply")


def test_a_difference_that_is_no_wrap_keeps_its_operands() -> None:
    traced = trace(lambda a: ((a.mantissa & 31) ^ 16) - 15, {"a": Fixed(9), "return": int})
    operation = traced.results["return"]
    assert operands_of(operation) == operation.operands
