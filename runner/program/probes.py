"""Rows of the probes: what a run records in the ticks of each."""

from collections.abc import Sequence

from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.due import due
from proofmass.runner.program.form import INTEGER, TRUTH, Operand, Storage, Value
from proofmass.runner.program.frame import Frame


class ProbeWriter:
    """Writes what the probes of a plan record, one array each."""

    def __init__(self, plan: Plan, frame: Frame, arrays: Sequence[Storage], first: Value) -> None:
        self.plan, self.frame, self.builder, self.arrays, self.first = plan, frame, frame.builder, arrays, first
        seldom = (number for number, probe in enumerate(plan.probes) if probe.stride > 1)
        self.rows = {number: self.builder.variable(INTEGER, f"row_{number}") for number in seldom}

    def record(self) -> None:
        """Rows of the probes."""
        for number, probe in enumerate(self.plan.probes):
            if probe.stride == 1:
                self._row(number, self.builder.compute("subtract_integers", self.frame.tick, self.first))
                continue
            row = self.rows[number]
            with self.builder.when(due(self.frame, probe.beat)):
                self._row(number, self.builder.get(row))
                self.builder.set(row, self.builder.compute("add_integers", self.builder.get(row), 1))

    def _row(self, number: int, row: Operand) -> None:
        probe, builder, array = self.plan.probes[number], self.builder, self.arrays[number]
        wire = self.frame.wire(probe.node)
        if not probe.shape:
            builder.store(array, row, wire)
            return
        width = probe.shape[0]
        begin = builder.compute("multiply_integers", row, width)
        with builder.counted(0, width, 1, "entry") as entry:
            value: Operand = builder.load(wire, entry)
            if array.entry is TRUTH:
                value = builder.compute("not_equal_integers", value, 0)
            builder.store(array, builder.compute("add_integers", begin, entry), value)
