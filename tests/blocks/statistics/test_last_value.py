"""The last sample before a tick, against the samples themselves."""

import pytest

from proofmass.blocks import LastValue
from tests.by_hand.functions import drive


@pytest.mark.parametrize(("until", "expected"), [(0, [0.0, 3.0, 1.0, 4.0, 1.0]), (2, [0.0, 3.0, 1.0, 1.0, 1.0])])
def test_it_keeps_the_last_sample_before_its_end(until: int, expected: list[float]) -> None:
    rows = drive(LastValue(until=until), [{"input": u} for u in (3.0, 1.0, 4.0, 1.0, 5.0)])
    assert [row["value"] for row in rows] == expected
