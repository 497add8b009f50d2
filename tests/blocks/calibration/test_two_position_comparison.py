"""Scale factor and bias of a known straight line, as found and as left."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import TwoPositionComparison
from tests.by_hand.functions import drive

G = 9.80665
IDLE = {"response": 1e9, "up": False, "read": False}


def pair(scale: float, bias: float, ups: tuple[bool, bool]) -> list[dict[str, object]]:
    ticks = [{"response": scale * ((G if up else -G) + bias), "up": up, "read": True} for up in ups]
    return [IDLE, ticks[0], IDLE, ticks[1], IDLE]


@given(st.floats(1.0, 1e5), st.floats(-1.0, 1.0), st.floats(-1e5, -1.0), st.floats(-1.0, 1.0), st.sampled_from([0, 1]))
def test_both_tests_whichever_position_is_first(found: float, b: float, left: float, c: float, turned: int) -> None:
    """N = K1 (a + K0 / K1): the first test stays, the latest is replaced."""
    ups = (bool(turned), not turned)
    rows = drive(TwoPositionComparison(), [*pair(found, b, ups), *pair(left, c, ups)])
    assert {rows[n][name] for n in range(4) for name in rows[n]} == {0.0}
    for row, (scale, bias) in ((rows[4], (found, b)), (rows[9], (left, c))):
        assert row["scale_factor_left"] == pytest.approx(scale, rel=1e-12)
        assert row["bias_left"] == pytest.approx(bias, abs=1e-12)
        assert row["scale_factor_found"] == pytest.approx(found, rel=1e-12)
        assert row["bias_found"] == pytest.approx(b, abs=1e-12)


def test_no_difference_has_no_bias() -> None:
    same = [{"response": 5.0, "up": up, "read": True} for up in (True, False)]
    row = drive(TwoPositionComparison(), [*same, IDLE])[-1]
    assert (row["scale_factor_found"], row["bias_found"]) == (0.0, 0.0)
