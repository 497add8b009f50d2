"""Runs side by side, against plain Python that runs each of them alone."""

from collections.abc import Mapping, Sequence
from typing import Any

from proofmass.runner.plan.keys import StateField
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import Interpreter
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes


def assert_lanes_are_runs(planned: Plan, given: Mapping[Any, Any], plans: Sequence[Plan], block: str) -> None:
    """Four runs with parameters of their own have the bits of each alone, in the states of a block."""
    lanes = Lanes(CompiledLanes(planned, set(given), 4), 7, range(4), given, plans)
    lanes.advance(90)
    for number, alone in enumerate(plans):
        run = Interpreter(alone, 7, number)
        run.advance(90, ())
        state = run.memory().states[block]
        found = [lanes.value(StateField(block, field))[number].item() for field in state._fields]
        assert list(map(repr, found)) == list(map(repr, state))
