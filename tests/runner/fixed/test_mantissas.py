"""What stands for an integer has all that rules of fixed point ask of one, and is told from others at once."""

import pytest

from proofmass.blocks.arithmetic.mantissa import Mantissa, selected
from proofmass.runner.derivatives.dual import Dual, dual
from proofmass.runner.fixed.affine import AffineMantissa
from proofmass.runner.fixed.signal import Signal
from proofmass.runner.rtl.proof.smt_integer import SmtInteger

OPERATORS = [
    "add",
    "radd",
    "sub",
    "rsub",
    "mul",
    "rmul",
    "lshift",
    "rshift",
    "and",
    "rand",
    "or",
    "ror",
    "xor",
    "rxor",
    "lt",
    "le",
    "gt",
    "ge",
    "neg",
]


@pytest.mark.parametrize("kind", [AffineMantissa, Dual, Signal, SmtInteger])
def test_each_is_a_mantissa_with_operators_of_its_own(kind: type) -> None:
    assert isinstance(kind.__new__(kind), Mantissa)
    assert {f"__{name}__" for name in OPERATORS} <= vars(kind).keys()
    assert "held" in vars(kind)
    assert type(kind) is type, "isinstance of a class with a metaclass is slow, and asked for every number"


def test_a_number_with_slopes_decides_a_choice_by_its_value() -> None:
    assert [selected(dual(number, {"x": 1.0}), "chosen", "other") for number in (3, 0)] == ["chosen", "other"]
