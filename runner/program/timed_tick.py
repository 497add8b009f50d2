"""The tick with a clock in it: the program of a plan that also counts the time each of its parts takes.

A reading of the clock stands between two parts of a tick. It waits until all before it is done, and
what follows waits for it. So each part is timed alone, as it is when nothing overlaps, and the
numbers are those of the plain tick. Between two readings with nothing between them stands the part
`CLOCK`: what a reading itself costs.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

from proofmass.graphs.checks.schedule import Beat
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.due import DueStep
from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, External, Variable
from proofmass.runner.program.groups import GroupWriter
from proofmass.runner.program.tick import TickWriter
from proofmass.runner.program.tick_loop import TickLoop

LOOP, CLOCK, CHECKS, RECORDING = "the loop itself", "the clock", "looking for NaN", "recording"
READ = External("read_clock", (), INTEGER, pure=False)
HOLD = {  # a value the processor must have before the next reading, and that LLVM knows nothing of
    kind: External(f"hold_{kind.name.lower()}", (kind,), kind, pure=False) for kind in (FLOAT, INTEGER, TRUTH)
}


def write_timed_tick(plan: Plan) -> tuple[TickLoop, tuple[str, ...]]:
    """Return the program of a plan with a clock, and the names of its parts in the order of its last array."""
    writer = TimedTick(plan)
    return writer.written(), tuple(writer.parts)


class TimedTick(TickWriter):
    """Writes the tick with a reading of the clock behind each of its parts."""

    def __init__(self, plan: Plan) -> None:
        super().__init__(plan)
        self.parts = {LOOP: 0, CLOCK: 1}  # places in the array of times
        self.times = self.builder.array(INTEGER, None, "times", True)
        self.before = self.builder.variable(INTEGER, "read_before")

    def mark(self, part: str) -> None:
        """Add the time since the last reading to a part."""
        builder, place = self.builder, self.parts.setdefault(part, len(self.parts))
        (now,) = builder.call(READ)
        spent = builder.compute("subtract_integers", now, builder.get(self.before))
        builder.store(self.times, place, builder.compute("add_integers", builder.load(self.times, place), spent))
        builder.set(self.before, now)

    def begin(self) -> None:
        """Read the clock for the first time."""
        super().begin()
        self.builder.set(self.before, self.builder.call(READ)[0])

    def outputs(self) -> None:
        """Time outputs one by one, and the check of all together."""
        self.mark(LOOP)
        self.mark(CLOCK)
        super().outputs()
        self.mark(CHECKS)

    def updates(self) -> None:
        """Time updates one by one; what was recorded before them first."""
        self.mark(RECORDING)
        super().updates()

    def update(self, name: str) -> None:
        """Time an update."""
        super().update(name)
        self._hold(self.frame.states.get(name))
        self.mark(name)

    def move_group(self, group: GroupWriter) -> None:
        """Time the step of a continuous group."""
        super().move_group(group)
        for name in dict.fromkeys(name for name, _ in group.group.states):
            self._hold(self.frame.states.get(name))
        self.mark(", ".join(group.group.blocks))

    def _in_order(self, drawn: set[str], looked_at: Any) -> Iterator[tuple[Beat, DueStep]]:
        for beat, step in super()._in_order(drawn, looked_at):
            yield beat, partial(self._timed, step)

    def _timed(self, step: Any) -> None:
        """Write a step and the reading behind it; it belongs to the block that the step names."""
        step()
        first = step.args[0]
        if isinstance(first, tuple):  # a wire that is held or looked at
            first = first[0]
        if step.func == self.output:
            self._hold_wire((first, step.args[1]))
        if isinstance(first, str):
            self.mark(first)
        else:
            loop = step.func.__self__
            for tear in loop.tears:
                self._hold_wire(tear)
            self.mark("loop of " + ", ".join(dict.fromkeys(name for name, _ in loop.tears)))

    def _hold_wire(self, node: Endpoint) -> None:
        self._hold(self.frame.wires.get(node))

    def _hold(self, lowered: Any) -> None:
        if isinstance(lowered, tuple):
            for part in lowered:
                self._hold(part)
        elif isinstance(lowered, Variable):
            self.builder.set(lowered, self.builder.call(HOLD[lowered.kind], self.builder.get(lowered))[0])
