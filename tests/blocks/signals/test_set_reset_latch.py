"""The latch by its table of states."""

import pytest

from proofmass.blocks import SetResetLatch
from tests.by_hand.responses import responses


@pytest.mark.parametrize(("set_wins", "both"), [(False, False), (True, True)])
def test_it_remembers(set_wins: bool, both: bool) -> None:
    set_ = [False, True, False, False, False, True, True, False]
    reset = [False, False, False, True, False, True, False, False]
    answer = responses(SetResetLatch(set_wins=set_wins), "on", set=set_, reset=reset)
    assert answer == [False, True, True, False, False, both, True, True]


def test_it_starts_as_it_is_told() -> None:
    known = {"set": [False, False], "reset": [False, True]}
    assert responses(SetResetLatch(initially_on=True), "on", **known) == [True, False]
