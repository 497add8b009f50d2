"""The unit delay shifts by one tick."""

from proofmass.blocks import UnitDelay
from tests.by_hand.functions import drive


def test_output_is_the_input_of_the_tick_before() -> None:
    inputs = [float(n * n - 7) for n in range(20)]
    rows = drive(UnitDelay(initial=-1.5), [{"input": u} for u in inputs])
    assert [row["output"] for row in rows] == [-1.5, *inputs[:-1]]


def test_it_breaks_a_loop_and_its_start_cannot_be_driven() -> None:
    assert UnitDelay.feedthrough("output") == ()
    assert not UnitDelay.drivable("initial")
