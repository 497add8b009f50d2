"""The zero bias: its law against the library's exponential, its hysteresis against what a play operator must do."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import ZeroBiasVoltage
from tests.by_hand.functions import drive

BARE = {"a1": 0.0, "a2": 0.0, "hysteresis": 1e-3, "width": 0.1}


def through(voltages: list[float], **parameters: float) -> list[float]:
    block = ZeroBiasVoltage(**parameters)  # type: ignore[arg-type]
    return [row["voltage"] for row in drive(block, [{"sensor_voltage": v} for v in voltages])]


@pytest.mark.parametrize("voltage", [0.6, 1.1, 1.8, -0.5])
def test_law_against_the_formula(voltage: float) -> None:
    found = through([voltage], a1=0.0139, b1=-3.0, a2=2.2e-5, b2=2.0, offset=1.65)[0]
    assert found == pytest.approx(
        0.0139 * math.exp(-3.0 * voltage) + 2.2e-5 * math.exp(2.0 * voltage) + 1.65, rel=1e-14
    )


def test_hysteresis_by_hand() -> None:
    up_and_down = [0.0, 0.05, 0.1, 0.5, 1.0, 0.95, 0.9, 0.85, 0.8, 0.5, 0.6]
    millivolts = [0.0, -0.5, -1.0, -1.0, -1.0, -0.5, 0.0, 0.5, 1.0, 1.0, 0.0]
    assert through(up_and_down, **BARE) == pytest.approx([1e-3 * m for m in millivolts], abs=1e-15)


def test_cooling_lies_above_warming_by_twice_the_amplitude() -> None:
    warming = np.linspace(0.6, 1.8, 121)
    found = np.array(through([*warming, *warming[::-1], *warming], **BARE))
    first, down, again = found[:121], found[121:242][::-1], found[242:]
    inside = (warming > 0.85) & (warming < 1.55)
    assert (down - again)[inside] == pytest.approx(2e-3, abs=1e-12)
    assert (first - again)[inside] == pytest.approx(0.0, abs=1e-12)


@given(st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=50))
def test_bounded_and_blind_to_pace(voltages: list[float]) -> None:
    found = through(voltages, **BARE)
    assert max(map(abs, found)) <= 1e-3 * (1.0 + 1e-12)
    held = [v for v in voltages for _ in range(3)]
    assert through(held, **BARE)[2::3] == found
