"""The plate on its stop, and free."""

from proofmass.blocks import PlateAttach
from tests.by_hand.functions import drive


def test_attached_it_hides_the_pendulum() -> None:
    inputs = [{"angle": a, "attach": b} for a, b in [(1e-4, False), (1e-4, True), (-2e-2, True), (-2e-2, False)]]
    rows = drive(PlateAttach(stop_angle="-1.25 mrad"), inputs)
    assert [row["plate_angle"] for row in rows] == [1e-4, -1.25e-3, -1.25e-3, -2e-2]
