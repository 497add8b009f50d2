"""Calibration sequencer: step' = step + 1 when its part is finished.

Steps 0 sweep, 1 switch, 2 test belong to the initial state; before step 3 the gains drift; 3 tests
what that does, 4 sweep and 5 switch estimate and compensate, 6 tests the cure; 7 is the end
(digital quartz accelerometer, Fig. 9).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param

DONE = 7


class CalibrationSequencer(Block):
    """State machine of estimation and compensation of the loop gains; its parts say when they are through.

    A part that is not wired takes one tick."""

    first: int = param("1", "Step to begin with; 3 where references are known.", default=0, at_least=0, at_most=DONE)

    sweep_finished = Input("1", "Whether the sweep of the forward gain is in its last tick.", dtype=bool, default=True)
    switch_finished = Input("1", "Whether the switching of the current is in its last tick.", dtype=bool, default=True)
    test_finished = Input("1", "Whether the static test is in its last tick.", dtype=bool, default=True)


class State(NamedTuple):
    step: int


@CalibrationSequencer.start
def start(p: CalibrationSequencer) -> State:
    return State(p.first)


@CalibrationSequencer.output("1")
def step(p: CalibrationSequencer, x: State) -> int:
    """The step, 7 when all is done."""
    return x.step


@CalibrationSequencer.output("1")
def sweep(p: CalibrationSequencer, x: State) -> bool:
    """True while the forward gain is estimated, the plate on its stop and the loop open."""
    return x.step == 0 or x.step == 4


@CalibrationSequencer.output("1")
def switch(p: CalibrationSequencer, x: State) -> bool:
    """True while the feedback gain is estimated."""
    return x.step == 1 or x.step == 5


@CalibrationSequencer.output("1")
def test(p: CalibrationSequencer, x: State) -> bool:
    """True during a static test."""
    return x.step == 2 or x.step == 3 or x.step == 6


@CalibrationSequencer.output("1")
def drifted(p: CalibrationSequencer, x: State) -> bool:
    """True once the initial state is over."""
    return x.step >= 3


@CalibrationSequencer.update
def update(
    p: CalibrationSequencer, x: State, sweep_finished: bool, switch_finished: bool, test_finished: bool
) -> State:
    if x.step == 0 or x.step == 4:
        finished = sweep_finished
    elif x.step == 1 or x.step == 5:
        finished = switch_finished
    else:
        finished = test_finished and x.step < DONE
    return State(x.step + 1 if finished else x.step)
