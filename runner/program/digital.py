"""Digital blocks in a program: calls of their integer code, and what becomes of an overflow.

A block's overflow is not 0 in a tick in which one of its values saturated or wrapped; its overflows
count such ticks. `refused` is not 0 from the first tick on in which a value did not fit its format
although it had to.
"""

from proofmass.blocks.declaration.instance import format_of
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.keys import word
from proofmass.runner.program.form import INTEGER, Function, Operand, Storage, Variable
from proofmass.runner.program.frame import Frame
from proofmass.runner.program.integer_step import call_step
from proofmass.runner.program.lower_numbers import as_kind
from proofmass.runner.program.structure import Lowered


class DigitalWriter:
    """Writes the calls of digital blocks and the counts of their overflows."""

    def __init__(self, frame: Frame, refused: Variable) -> None:
        self.frame, self.plan, self.refused = frame, frame.plan, refused
        self.dropping: Function | None = None  # which shifts' drops pass, see `call_step`
        self.resting: Function | None = None  # which what searches leave over passes
        self.counted = [name for name, block in self.plan.digital.items() if block.overflows]
        self.counts: dict[str, Variable] = {}
        self._lost = {name: frame.builder.variable(INTEGER, f"{word(name)}_overflow") for name in self.counted}

    def begin_tick(self) -> None:
        """Set the overflow of each block to none."""
        for lost in self._lost.values():
            self.frame.builder.set(lost, 0)

    def end_tick(self) -> None:
        """Count overflows, under one condition that seldom holds."""
        builder = self.frame.builder
        if not self.counted:
            return
        every: Operand = builder.get(self._lost[self.counted[0]])
        for name in self.counted[1:]:
            every = builder.compute("or", every, builder.get(self._lost[name]))
        with builder.when(builder.compute("not_equal_integers", every, 0)):
            for name in self.counted:
                lost = builder.compute("not_equal_integers", builder.get(self._lost[name]), 0)
                more = builder.compute("integer_of_truth", lost)
                builder.set(self.counts[name], builder.compute("add_integers", builder.get(self.counts[name]), more))

    def call(self, name: str, function: str) -> Lowered:
        """Call the integer code of a digital block and return its result."""
        step, frame = self.plan.digital[name].steps[function], self.frame
        given = [frame.now(frame.constants[name]), *map(frame.argument, self.plan.bindings(name, function))]
        code = step.slope_code if self.resting else step.code
        result, beside = call_step(frame.builder, code, given, self.dropping, self.resting)
        flags = ([self._lost[name]] if step.overflows else []) + ([self.refused] if step.refuses else [])
        for flag, value in zip(flags, beside, strict=True):
            self._note(flag, value)
        return result

    def hold(self, node: Endpoint) -> None:
        """Check that a converter's mantissas fit their format: integer code relies on it until the chunk ends."""
        builder, wire = self.frame.builder, self.frame.wires[node]
        block = self.plan.blocks[node[0]]
        format = format_of(block, node[1])

        def fitted(value: Operand) -> Operand:
            low = builder.compute(
                "select", builder.compute("less_integers", value, format.lowest), format.lowest, value
            )
            high = builder.compute("less_integers", format.highest, low)
            held = builder.compute("select", high, format.highest, low)
            self._note(self.refused, builder.compute("xor", held, value))
            return held

        if isinstance(wire, Storage):
            assert wire.length is not None
            for place in range(wire.length):
                builder.store(wire, place, fitted(builder.load(wire, place)))
        else:
            builder.set(wire, fitted(builder.get(wire)))

    def _note(self, flag: Variable, value: Operand) -> None:
        builder = self.frame.builder
        builder.set(flag, builder.compute("or", builder.get(flag), as_kind(builder, value, INTEGER)))
