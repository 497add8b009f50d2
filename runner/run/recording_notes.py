"""Notes on recordings: gaps, and what is played before their first and after their last row."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from statistics import median

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.plan.planned import Plan

REGULAR = 0.9  # part of the steps of a recording that is sampled at a rate
JITTER = 0.5  # by which these differ at most from the usual step
GAP = 3.0  # usual steps
LITTLE = 0.01  # part of a recording that is played


def recording_notes(plan: Plan, end: Fraction | None) -> Iterator[Problem]:
    """Notes on the recordings of a plan, for a run up to a time, None if unknown."""
    for name, block in plan.blocks.items():
        buffers = {declared.recorded: buffer for buffer, declared in type(block).buffers.items() if declared.recorded}
        if "time" not in buffers:
            continue
        times = plan.buffers[name, buffers["time"]]
        for message, hint in _told(times, end):
            yield plan.graph.placed(
                Problem(
                    message=message,
                    got=str(getattr(block, "file", "")),
                    hint=hint,
                    note=True,
                    path=("blocks", name, "file"),
                )
            )


def _told(times: Sequence[float], end: Fraction | None) -> Iterator[tuple[str, str]]:
    if times[0] > 0.0:
        message = f"the recording begins at {times[0]:.6g} s: its first value is played from 0 s on"
        yield message, f"subtract {times[0]:.6g} s from its times where it should begin with the run"
    steps = [after - before for before, after in pairwise(times)]
    usual = median(steps) if steps else 0.0
    if end is not None and end > times[-1] + usual:
        message = f"the recording ends at {times[-1]:.6g} s, the run at {float(end):.6g} s: its last value is held"
        yield message, "run for a shorter time"
    if end is not None and float(end) < LITTLE * times[-1]:
        message = f"the recording lasts until {times[-1]:.6g} s, the run until {float(end):.6g} s"
        yield message, "times are seconds where their head says no other unit: write time [ms] for milliseconds"
    gaps = [number for number, step in enumerate(steps) if step > GAP * usual]
    if gaps and sum(abs(step - usual) <= JITTER * usual for step in steps) >= REGULAR * len(steps):
        longest = max(gaps, key=lambda number: steps[number])
        ends = f"from {times[longest]:.6g} to {times[longest + 1]:.6g} s"
        said = f"a gap {ends}" if len(gaps) == 1 else f"{len(gaps)} gaps, the longest {ends}"
        message = f"the recording has {said}, where {usual:.4g} s lie between other values: it is bridged"
        yield message, "fill it, or make recordings of their own of what lies before and after"
