"""The register in fixed point against the one that divides."""

import pytest

from proofmass.blocks import CompensationRegister, FixedCompensationRegister
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import drive_fixed
from tests.by_hand.functions import drive

ONE = 1 << 23


def loaded(block: FixedCompensationRegister, deviations: list[float]) -> list[float]:
    rows = [{"deviation": round(d * ONE), "load": True} for d in deviations]
    found = drive_fixed(block, [*rows, {"deviation": 0, "load": False}])
    return [row["value"] / 2.0**block.output_format.fraction for row in found]


@pytest.mark.parametrize("deviation", [200e-6, -200e-6, 5e-3, -9e-3])
def test_one_load_is_right_to_the_square_of_the_deviation(deviation: float) -> None:
    before, after = loaded(FixedCompensationRegister(), [deviation])
    assert before == 1.0
    assert after == pytest.approx(1.0 / (1.0 + deviation), abs=1.01 * deviation**2 + 2e-7)
    assert after == pytest.approx(1.0 - deviation, abs=2e-7)


def test_loads_that_measure_what_is_left_converge_to_the_quotient() -> None:
    gain, value = 1.004, 1.0
    block = FixedCompensationRegister()
    deviations: list[float] = []
    for _ in range(4):
        deviations.append(gain * value - 1.0)
        value = loaded(block, deviations)[-1]
    assert value == pytest.approx(1.0 / gain, abs=3e-7)
    reference = [{"deviation": gain - 1.0, "load": True}, {"deviation": 0.0, "load": False}]
    assert value == pytest.approx(drive(CompensationRegister(), reference)[-1]["value"], abs=3e-7)


def test_without_a_load_nothing_moves() -> None:
    rows = [{"deviation": 40_000, "load": False}] * 3
    assert [row["value"] for row in drive_fixed(FixedCompensationRegister(initial=0.5), rows)] == [1 << 29] * 3


def test_value_and_deviation_keep_their_limits() -> None:
    block = FixedCompensationRegister(initial=1.5, limit=0.02)
    found = loaded(block, [-0.9, -0.9, 0.5, 0.5, 0.5])
    assert found[1] == pytest.approx(1.53, abs=1e-6)  # a deviation counts as at most its limit
    assert found[2] == pytest.approx(1.53, abs=1e-9)
    assert found[-1] == pytest.approx(1.47, abs=1e-9)


def test_a_value_beyond_its_format_is_refused() -> None:
    with pytest.raises(ValueError, match="does not fit"):
        loaded(FixedCompensationRegister(initial=1.995, output_format=Fixed(32, 30)), [0.0])
