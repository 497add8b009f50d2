"""The check at both ends of both tolerances."""

import pytest

from proofmass.blocks import ToleranceCheck
from tests.by_hand.functions import drive


@pytest.mark.parametrize(
    ("stiffness", "damping", "inside"),
    [
        (0.0, 0.0, True),
        (0.0499, -0.1999, True),
        (-0.0499, 0.1999, True),
        (0.0501, 0.0, False),
        (-0.0501, 0.0, False),
        (0.0, 0.2001, False),
        (0.0, -0.2001, False),
        (0.06, 0.3, False),
    ],
)
def test_ends_of_the_tolerances(stiffness: float, damping: float, inside: bool) -> None:
    device = {"stiffness": 51.48 * (1.0 + stiffness), "damping": 4.57e-3 * (1.0 + damping)}
    assert drive(ToleranceCheck(), [device])[0]["inside"] is inside


def test_a_tolerance_of_nothing_takes_the_nominal_alone() -> None:
    block = ToleranceCheck(stiffness_nominal=50.0, stiffness_tolerance=0.0, damping_nominal=1.0, damping_tolerance=0.0)
    rows = drive(block, [{"stiffness": 50.0, "damping": 1.0}, {"stiffness": 50.0 + 1e-12, "damping": 1.0}])
    assert [row["inside"] for row in rows] == [True, False]
