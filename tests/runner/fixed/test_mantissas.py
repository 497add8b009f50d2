"""What stands for an integer has all that rules of fixed point ask of one, and is told from others at once."""

import pytest

from proofmass.blocks.arithmetic.mantissa import Mantissa
from proofmass.runner.derivatives.dual import Dual
from proofmass.runner.fixed.signal import Signal
from proofmass.runner.rtl.proof.smt_integer import SmtInteger


@pytest.mark.parametrize("kind", [Dual, Signal, SmtInteger])
def test_each_is_a_mantissa_without_deriving_from_one(kind: type) -> None:
    assert isinstance(kind.__new__(kind), Mantissa)
    assert type(kind) is type, "isinstance of a class with a metaclass is slow, and asked for every number"
