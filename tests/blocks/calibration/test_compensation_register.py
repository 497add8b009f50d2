"""The register makes up for a gain exactly, stepwise, within its limit."""

import pytest

from proofmass.blocks import CompensationRegister
from tests.by_hand.functions import drive


def values(block: CompensationRegister, loads: list[tuple[float, bool]]) -> list[float]:
    return [row["value"] for row in drive(block, [{"deviation": d, "load": b} for d, b in [*loads, (0.0, False)]])]


def test_value_over_one_plus_the_deviation() -> None:
    """N_VREF after the feedback gain fell by 200 ppm: eq. 30 of the paper."""
    found = values(CompensationRegister(initial=524288.0), [(0.5, False), (-200e-6, True), (-200e-6, False)])
    assert found == [524288.0, 524288.0, 524288.0 * (1.0 / (1.0 - 200e-6)), 524288.0 * (1.0 / (1.0 - 200e-6))]


def test_what_is_left_is_corrected_by_the_next_load() -> None:
    gain, value, loads = 0.9987, 1.0, []
    for _ in range(3):
        deviation = 0.9 * (gain * value - 1.0)  # an estimator that reads 10 % low
        loads.append((deviation, True))
        value /= 1.0 + deviation
    assert gain * values(CompensationRegister(), loads)[-1] == pytest.approx(1.0, abs=2e-6)


def test_within_its_limit() -> None:
    assert values(CompensationRegister(), [(-0.9, True), (-0.9, True)])[1:] == [1.01, 1.01]
    assert values(CompensationRegister(initial=-2.0), [(0.5, True), (0.5, True)])[2] == -2.0 * 0.99
