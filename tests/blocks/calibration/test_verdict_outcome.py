"""The four outcomes of a test."""

import pytest

from proofmass.blocks import VerdictOutcome
from tests.by_hand.functions import drive


@pytest.mark.parametrize(
    ("passes", "good", "yield_loss", "test_escape"),
    [(True, True, 0.0, 0.0), (False, True, 1.0, 0.0), (True, False, 0.0, 1.0), (False, False, 0.0, 0.0)],
)
def test_outcomes(passes: bool, good: bool, yield_loss: float, test_escape: float) -> None:
    row = drive(VerdictOutcome(), [{"passes": passes, "good": good}])[0]
    assert row == {"yield_loss": yield_loss, "test_escape": test_escape}
