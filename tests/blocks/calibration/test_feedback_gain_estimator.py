"""The difference of means, and the rules of reference and deviation."""

import pytest

from proofmass.blocks import FeedbackGainEstimator
from tests.by_hand.functions import drive


def measurement(responses: list[float], ons: str) -> list[dict[str, object]]:
    last = len(ons) - 1
    return [
        tick
        for n, (response, on) in enumerate(zip(responses, ons, strict=True))
        for tick in (
            {"response": 9e9, "on": on == "A", "read": False, "last": n == last},
            {"response": response, "on": on == "A", "read": True, "last": n == last},
        )
    ]


IDLE = [{"response": 0.0, "on": False, "read": False, "last": False}] * 2


def test_on_less_off_and_its_deviation() -> None:
    """The first row of the paper's Table 4 [P]: 223.03 ppm."""
    ticks = measurement([-158297.13, -86558.35], "AB") + measurement([-158330.0, -86575.22], "AB")
    rows = drive(FeedbackGainEstimator(), [*ticks, *IDLE])
    assert rows[4]["difference"] == pytest.approx(-71738.78, abs=1e-9)
    assert rows[-1]["difference"] == pytest.approx(-71754.78, abs=1e-9)
    assert [row["known_difference"] for row in rows] == [0.0] * 4 + [rows[4]["difference"]] * 6
    assert 1e6 * rows[-1]["deviation"] == pytest.approx(223.03, abs=0.005)
    assert (1.0 + rows[-1]["deviation"]) * (1.0 + rows[-1]["gain_deviation"]) == pytest.approx(1.0, rel=1e-15)
    assert [n for n, row in enumerate(rows) if row["estimated"]] == [8]


@pytest.mark.parametrize(("ons", "error"), [("AB", -1.0), ("ABAB", -1.0), ("ABBA", 0.0), ("ABBAABBA", 0.0)])
def test_a_palindrome_is_blind_to_linear_drift(ons: str, error: float) -> None:
    responses = [100.0 * (on == "A") + float(n) for n, on in enumerate(ons)]
    rows = drive(FeedbackGainEstimator(), [*measurement(responses, ons), *IDLE])
    assert rows[-1]["difference"] == 100.0 + error


def test_before_a_whole_measurement_and_without_both_states_there_is_nothing() -> None:
    rows = drive(FeedbackGainEstimator(reference=5.0), [*measurement([1.0, 2.0], "AA"), *IDLE])
    assert {(row["difference"], row["deviation"], row["gain_deviation"]) for row in rows} == {(0.0, 0.0, 0.0)}
