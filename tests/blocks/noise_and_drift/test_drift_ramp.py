"""The linear drift against its closed form."""

from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import DriftRamp
from tests.by_hand.functions import drive


def test_so_much_per_hour() -> None:
    rows = drive(DriftRamp(slope="3.6 ppm/h", nominal=2.0), [{}] * 5, period=1000.0)
    for tick, row in enumerate(rows):
        assert row["deviation"] == 1e-9 * (1000.0 * tick)
        assert row["value"] == 2.0 * (1.0 + 1e-9 * (1000.0 * tick))


@given(st.floats(-1e3, 1e3), st.floats(0.0, 10.0))
def test_nominal_until_the_start(slope: float, start_time: float) -> None:
    for tick, row in enumerate(drive(DriftRamp(slope=slope, start_time=start_time, nominal=7.0), [{}] * 10)):
        assert row["deviation"] == (0.0 if tick <= start_time else slope * (tick - start_time))
        assert tick > start_time or row["value"] == 7.0
