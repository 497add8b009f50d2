"""The ramp against its closed form."""

from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Ramp
from tests.by_hand.functions import drive


def test_held_until_the_start_and_straight_after_it() -> None:
    rows = drive(Ramp(offset=2.0, slope=-4.0, start_time=1.0), [{}] * 17, period=0.125)
    assert [row["output"] for row in rows] == [2.0] * 8 + [2.0 - 0.5 * n for n in range(9)]


def test_slope_in_its_own_unit() -> None:
    block = Ramp(slope="3.6 mV/h", unit="V")
    assert block.slope == 1e-6
    assert drive(block, [{}, {}], period=1000.0)[1]["output"] == 1e-6 * 1000.0


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.floats(0.0, 10.0))
def test_never_before_the_start(offset: float, slope: float, start_time: float) -> None:
    rows = drive(Ramp(offset=offset, slope=slope, start_time=start_time), [{}] * 10)
    for tick, row in enumerate(rows):
        assert row["output"] == (offset if tick <= start_time else offset + slope * (tick - start_time))
