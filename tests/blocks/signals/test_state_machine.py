"""The machine against a dictionary of transitions, and tables that are none."""

import random

import pytest

from proofmass.blocks import StateMachine
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_against_a_dictionary() -> None:
    dice = random.Random(5)
    following = {(s, a, b): dice.randrange(5) for s in range(5) for b in (False, True) for a in (False, True)}
    values = (2.5, -1.0, 0.0, 4.0, 8.0)
    block = StateMachine(following=tuple(map(float, following.values())), values=values, initial=3)
    rows = [
        {"first": dice.random() < 0.5, "second": dice.random() < 0.5, "reset": dice.random() < 0.1} for _ in range(300)
    ]
    now, expected = 3, []
    for row in rows:
        expected.append((now, values[now]))
        now = 3 if row["reset"] else following[now, row["first"], row["second"]]
    assert [(row["state"], row["value"]) for row in drive(block, rows, 1.0)] == expected
    assert len({state for state, _ in expected}) == 5


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"following": (0.0,) * 7}, "8 of them"),
        ({"following": (0.0,) * 7 + (2.0,)}, "0 to 1"),
        ({"following": (0.0,) * 7 + (0.5,)}, "0 to 1"),
        ({"initial": 2}, "at most 1"),
        ({"values": (0.0,) * 257, "following": (0.0,) * 4 * 257}, "at most 256 of them"),
    ],
)
def test_what_is_no_table(table: dict[str, object], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        StateMachine(**table)


def test_256_states_are_taken() -> None:
    assert len(StateMachine(values=(0.0,) * 256, following=(0.0,) * 4 * 256).values) == 256
