"""The relay: its hysteresis by hand; its switching times in closed form are in tests/runner/planning/test_events.py."""

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.signals.relay import Relay, State, distance, last_switching, output, switch, switchings

OFF, ON = State(False, 0, 0.0), State(True, 3, 0.25)


def test_it_switches_on_at_upper_and_off_at_lower() -> None:
    p = Relay(lower=-1.0, upper=2.0)
    assert distance(p, OFF, 1.5) == 0.5
    assert distance(p, OFF, 2.0) == 0.0
    assert distance(p, ON, -0.5) == 0.5
    assert distance(p, ON, -1.0) == 0.0
    assert distance(p, ON, 1e9) > 0.0 < distance(p, OFF, -1e9)


def test_after_switching_it_is_far_from_switching_again() -> None:
    p = Relay(lower=-1.0, upper=2.0)
    assert distance(p, switch(p, OFF, 0.5), 2.0) == 3.0
    assert distance(p, switch(p, ON, 0.5), -1.0) == 3.0


def test_outputs() -> None:
    p = Relay(off=-4.0, on=7.0)
    assert (output(p, OFF), output(p, ON)) == (-4.0, 7.0)
    assert switch(p, ON, 0.75) == State(False, 4, 0.75)
    assert (switchings(p, ON), last_switching(p, ON)) == (3, 0.25)
    assert Relay.feedthrough("output") == ()


def test_a_relay_without_hysteresis_is_refused() -> None:
    with pytest.raises(ModelError, match="it would switch without end"):
        Relay(lower=1.0, upper=1.0)


@pytest.mark.defect("S9", before="a Relay always starts off", after="the parameter initially_on")
def test_it_starts_as_it_is_told() -> None:
    start = Relay.functions["start"].function
    assert start(Relay()) == OFF
    assert start(Relay(initially_on=True)) == State(True, 0, 0.0)
    assert distance(Relay(), start(Relay(initially_on=True)), 0.25) == 0.75
