"""The state machine against the list of its steps."""

import random

from proofmass.blocks import CalibrationSequencer
from tests.by_hand.functions import drive

PARTS = ["sweep", "switch", "test", "test", "sweep", "switch", "test"]  # Fig. 9 of the paper


def run(finished: list[dict[str, bool]], first: int = 0) -> list[dict[str, object]]:
    return drive(
        CalibrationSequencer(first=first), [{f"{k}_finished": v for k, v in tick.items()} for tick in finished]
    )


def test_only_the_part_under_way_moves_it_on() -> None:
    dice = random.Random(9)
    ticks = [{part: dice.random() < 0.2 for part in ("sweep", "switch", "test")} for _ in range(200)]
    step = 0
    for tick, row in zip(ticks, run(ticks), strict=True):
        under_way = PARTS[step] if step < 7 else ""
        assert row["step"] == step
        assert {part for part in ("sweep", "switch", "test") if row[part]} == ({under_way} if under_way else set())
        assert row["drifted"] == (step >= 3)
        step += bool(under_way) and tick[under_way]
    assert step == 7


def test_a_part_that_is_not_wired_takes_one_tick() -> None:
    assert all(port.default == 1.0 for port in CalibrationSequencer.inputs.values())
    rows = run([{"sweep": n in (3, 10), "switch": True, "test": True} for n in range(14)])
    assert [row["step"] for row in rows] == [0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4, 5, 6, 7]


def test_a_sensor_whose_references_are_known_begins_with_its_test() -> None:
    rows = run([{"sweep": True, "switch": True, "test": True}] * 6, first=3)
    assert [row["step"] for row in rows] == [3, 4, 5, 6, 7, 7]
    assert [row["test"] for row in rows] == [True, False, False, True, False, False]
