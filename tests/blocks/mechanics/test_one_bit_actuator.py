"""The two levels of the one-bit actuator."""

import math

import pytest

from proofmass.blocks import OneBitActuator
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_one_is_plus_the_level_and_zero_is_minus() -> None:
    rows = drive(OneBitActuator(), [{"bit": bit} for bit in (True, False, False, True)])
    assert [row["output"] for row in rows] == [1.0e-6, -1.0e-6, -1.0e-6, 1.0e-6]


def test_unit_and_level_go_together() -> None:
    block = OneBitActuator(unit="V", level="1694 mV")
    assert block.level == 1.694
    assert unit_of(block, type(block).outputs["output"]) == "V"
    with pytest.raises(ModelError, match=r"hint: +give it in N"):
        OneBitActuator(level="1.694 V")


def test_no_level_is_refused() -> None:
    with pytest.raises(ModelError, match="must be > 0"):
        OneBitActuator(level=0.0)


@pytest.mark.derivation(
    OneBitActuator,
    equation="output = +level for a one, -level for a zero",
    source="autocorrelation of a maximal sequence of 31 bits, x^5 + x^2 + 1, by hand: N level^2 and -level^2",
    convention="level is half of the swing, and the rms",
)
def test_the_autocorrelation_of_a_maximal_sequence() -> None:
    bits = [True, False, False, False, False]
    while len(bits) < 31:
        bits.append(bits[-5] != bits[-3])
    forces = [row["output"] for row in drive(OneBitActuator(level=3.0), [{"bit": bit} for bit in bits])]
    sums = [math.fsum(forces[n] * forces[(n + late) % 31] for n in range(31)) for late in range(31)]
    assert sums == [31 * 9.0] + [-9.0] * 30
    assert max(forces) - min(forces) == 6.0
