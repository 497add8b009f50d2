"""The plate on its stop, and free."""

import math

import pytest

from proofmass.blocks import PlateAttach
from tests.by_hand.functions import drive


def test_attached_it_hides_the_pendulum() -> None:
    inputs = [{"angle": a, "attach": b} for a, b in [(1e-4, False), (1e-4, True), (-2e-2, True), (-2e-2, False)]]
    rows = drive(PlateAttach(stop_angle="-1.25 mrad"), inputs)
    assert [row["plate_angle"] for row in rows] == [1e-4, -1.25e-3, -1.25e-3, -2e-2]


@pytest.mark.derivation(
    PlateAttach,
    equation="plate_angle = stop_angle while attached, else that of the pendulum",
    source="arc of an arm of 10 mm that meets a plate 12.5 um away: asin(gap / lever)",
    convention="gap of one side, angle in rad from the middle; the default is that of GapCapacitorPair's gap and lever",
)
def test_the_angle_of_an_arm_on_its_stop() -> None:
    (row,) = drive(PlateAttach(), [{"angle": 0.3, "attach": True}])
    assert row["plate_angle"] == pytest.approx(math.asin(12.5e-6 / 10e-3), rel=1e-6)
