"""The slope against NumPy's least squares, and the rules of reference and deviation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import ForwardGainEstimator
from tests.by_hand.functions import drive


def sweep(numbers: list[float], responses: list[float]) -> list[dict[str, object]]:
    """Points with an idle tick before each."""
    ticks: list[dict[str, object]] = []
    for n, (x, y) in enumerate(zip(numbers, responses, strict=True)):
        ticks.append({"number": x, "response": -1.0, "read": False, "last": False})
        ticks.append({"number": x, "response": y, "read": True, "last": n + 1 == len(numbers)})
    return ticks


IDLE = [{"number": 0.0, "response": 0.0, "read": False, "last": False}] * 2
NUMBERS = [4000.0 + 1000.0 * i for i in range(11)]


@given(st.lists(st.floats(-1e6, 1e6), min_size=11, max_size=11))
def test_against_numpy_least_squares(responses: list[float]) -> None:
    row = drive(ForwardGainEstimator(), [*sweep(NUMBERS, responses), *IDLE])[-1]
    assert row["slope"] == pytest.approx(np.polyfit(NUMBERS, responses, 1)[0], rel=1e-9, abs=1e-7)


def test_exact_on_a_line_and_blind_to_its_offset() -> None:
    """The paper's first gain, 478.974 [P], and one 200 ppm lower."""
    ticks = []
    for slope, offset in [(478.974, 12345.0), (478.974 * (1.0 - 200e-6), -1e6)]:
        ticks += sweep(NUMBERS, [offset + slope * n for n in NUMBERS])
    rows = drive(ForwardGainEstimator(), [*ticks, *IDLE])
    assert rows[22]["slope"] == pytest.approx(478.974, rel=1e-12)
    assert rows[22]["deviation"] == 0.0
    assert {row["known_slope"] for row in rows[22:]} == {rows[22]["slope"]}
    assert rows[44]["deviation"] == pytest.approx(-200e-6, rel=1e-9)
    assert [n for n, row in enumerate(rows) if row["estimated"]] == [44]


def test_far_from_zero_no_digits_are_lost() -> None:
    row = drive(
        ForwardGainEstimator(), [*sweep([1e15 + n for n in range(11)], [-1e15 + 3.0 * n for n in range(11)]), *IDLE]
    )
    assert row[-1]["slope"] == 3.0


def test_a_reference_of_its_own() -> None:
    rows = drive(ForwardGainEstimator(reference=2.0), [*sweep([0.0, 1.0], [0.0, 3.0]), *IDLE])
    assert (rows[4]["slope"], rows[4]["deviation"], rows[4]["estimated"]) == (3.0, 0.5, True)
    assert {row["known_slope"] for row in rows} == {2.0}


def test_a_sweep_without_spread_has_no_slope() -> None:
    rows = drive(ForwardGainEstimator(), [*sweep([5.0, 5.0], [1.0, 2.0]), *IDLE])
    assert (rows[-1]["slope"], rows[-1]["deviation"]) == (0.0, 0.0)
