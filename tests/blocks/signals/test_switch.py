"""The switch: one signal or the other, in the same tick."""

from proofmass.blocks import Switch
from tests.by_hand.responses import responses


def test_it_chooses_in_the_same_tick() -> None:
    first, second, bits = [1.0, 2.0, 3.0, 4.0], [-1.0, -2.0, -3.0, -4.0], [True, False, False, True]
    assert responses(Switch(), first=first, second=second, choose_first=bits) == [1.0, -2.0, -3.0, 4.0]
