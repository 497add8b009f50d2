"""How far numbers of the digital part get beyond what they hold, in steps and in words."""

import math
from typing import Any

import pytest

from proofmass.runner.design.proof.digital_inputs import DigitalInput
from proofmass.runner.design.proof.digital_proof import (
    NO_OVERFLOW,
    ROUNDING,
    DigitalProof,
    ValueRoom,
    _fullest,
    _room_of_quantiser,
)


@pytest.mark.parametrize(
    ("low", "high", "below", "above"),
    [
        (-8.0, 7.0, 0.0, 0.0),
        (-8.9, 7.9, 0.0, 0.0),  # whole numbers within
        (-9.0, 8.0, 1.0, 1.0),
        (-3.5, 9.5, -5.0, 2.0),
        (-math.inf, math.inf, math.inf, math.inf),
    ],
)
def test_steps_beyond_a_range(low: float, high: float, below: float, above: float) -> None:
    room = ValueRoom("a.sum", low, high, -8, 7)
    assert (room.beyond_low, room.beyond_high) == (below, above)
    assert room.is_kept is (below <= 0.0 and above <= 0.0)
    assert room.beyond == max(below, above) / 8.0


def test_a_range_without_an_end_is_kept_there() -> None:
    anything = ValueRoom("a", -1e9, 1e9, None, None)
    assert (anything.beyond_low, anything.beyond_high, anything.is_kept) == (-math.inf, -math.inf, True)
    assert ValueRoom("a", -1e9, 9.0, None, 7).beyond == 2.0 / 7.0
    assert ValueRoom("a", -9.0, 1e9, -7, None).beyond == 2.0 / 7.0
    assert ValueRoom("a", 0.0, 3.0, 0, 0).beyond == 3.0
    assert not ValueRoom("a", -9.0, 0.0, -8, 7).is_kept
    assert not ValueRoom("a", 0.0, 8.0, -8, 7).is_kept


def test_rooms_in_words_and_as_data() -> None:
    room = ValueRoom("a.sum", -8.9, 7.9, -8, 7)
    assert str(room) == "a.sum gets from -8 to 7 steps, and holds -8 to 7"
    assert str(ValueRoom("a.sum", -8.9, math.inf, None, 7)) == "a.sum has no bound, and holds any to 7 steps"
    assert str(ValueRoom("a.sum", -8.0, 9.0, -8, None)) == "a.sum gets from -8 to 9 steps, and holds -8 to any"
    assert room.as_data() == {"at": "a.sum", "low": -8.9, "high": 7.9, "lowest": -8, "highest": 7}
    assert ValueRoom("a", -math.inf, 1.0, None, 7).as_data()["low"] is None


def test_the_fullest_come_first() -> None:
    rooms = [ValueRoom(name, 3.0, high, 0, 7) for name, high in (("a", 5.0), ("b", 9.0), ("c", 7.0))]
    assert [room.at for room in _fullest(rooms)] == ["b", "c", "a"]


def test_what_a_quantiser_gives_before_it_limits() -> None:
    given: Any = {"signal": "x", "low": -1.0, "high": 1.0, "unit": "1", "stated": True, "driven": True}
    plain = DigitalInput(("adc", "code"), mantissas=(-3, 4), format=(-8, 7), **given)
    over = DigitalInput(("adc", "code"), mantissas=(-8, 7), format=(-8, 7), over=(-20, 30), **given)
    assert _room_of_quantiser(plain) == ValueRoom("adc.code", -3.0, 4.0, -8, 7)
    assert _room_of_quantiser(over) == ValueRoom("adc.code", -20.0, 30.0, -8, 7)


def test_claims_in_words() -> None:
    assert str(DigitalProof(NO_OVERFLOW, "", 0.0, "", "open")) == NO_OVERFLOW
    assert str(DigitalProof(ROUNDING, "a.b", 0.002, "V", "open")) == f"{ROUNDING} of at most 2 mV"
    assert str(DigitalProof(ROUNDING, "a.b", math.inf, "V", "open")) == f"{ROUNDING} without a bound"
    data = DigitalProof(ROUNDING, "a.b", math.inf, "V", "open", error=(-1.0, 2.0)).as_data()
    assert data["limit"] is None
