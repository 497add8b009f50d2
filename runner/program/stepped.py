"""Groups of continuous blocks that move in steps, of fixed length or chosen by error and events."""

from collections.abc import Sequence

from proofmass.runner.continuous.integrate import GroupTick, integrate
from proofmass.runner.continuous.methods import EXPLICIT, explicit_step
from proofmass.runner.continuous.radau import radau_step, scratch
from proofmass.runner.plan.groups import state_fields
from proofmass.runner.plan.solver import Solver
from proofmass.runner.program.build import Builder, WrittenNumber, operand, parameters_like, zero
from proofmass.runner.program.form import FLOAT, INTEGER, Function, Storage
from proofmass.runner.program.frame import Frame
from proofmass.runner.program.groups import ExactGroup, GroupContext, GroupWriter, WritesTick
from proofmass.runner.program.lower import call
from proofmass.runner.program.lower_numbers import as_kind
from proofmass.runner.program.structure import Lowered, leaves


def group_writer(writer: WritesTick, solver: Solver) -> GroupWriter:
    """The writer of a group."""
    return ExactGroup(writer, solver) if solver.exact else SteppedGroup(writer, solver)


class SteppedGroup(GroupWriter):
    """A group that moves in steps."""

    def begin(self) -> None:
        solver, size = self.solver, len(self.group.states)
        self.fixed = not solver.tolerance and not self.group.watched
        self.substeps = self.number("substeps", int, solver.substeps)
        steps = self.builder.compute("float_of_integer", self.substeps)
        self.length = self.builder.compute("divide", self.writer.period, steps, name=f"{self.name}_length")
        if not self.fixed:
            self.tolerance = self.number("tolerance", float, solver.allowed)
            self.precision = self.number("precision", float, solver.precision)
        self.x, self.moved, self.error = (self._array(key, size) for key in ("x", "moved", "error"))
        self.begun = self._array("begun", 2 * size)  # states at the start of a tick, and their largest values there
        self.clear, self.side = (self._array(key, self.group.watched) for key in ("clear", "side"))
        self.largest = self.frame.wires[solver.largest] if solver.tolerance else self._array("largest", size)
        lengths = scratch(size) if solver.method == "radau" else ()
        self.steps_work = tuple(self._array(f"work_{i}", length) for i, length in enumerate(lengths))
        none = operand(0.0)
        inputs = tuple(zero(self.frame.wires[node].kind) for node in self.group.inputs)
        slopes, guesses = (none,) * len(self.group.ramps), (none,) * len(self.group.guesses)
        example = GroupContext(self.constants(), inputs, slopes, guesses, none, self.work())
        self.functions = self._functions(example)

    def _array(self, key: str, length: int) -> Storage:
        return self.writer.numbers.scratch(f"{self.name}_{key}", length)

    def _functions(self, context: GroupContext) -> tuple[Function, ...]:
        """Functions that step the group and handle its events."""
        rates = self.rates(context)
        context_and_work: Lowered = context
        if self.solver.method == "radau":
            context_and_work = (context, self.largest, self.steps_work)
            step = self._radau(context_and_work, rates)
        else:
            step = self._explicit(context, rates)
        return (step,) if self.fixed else (step, self._clearances(context_and_work), self._then(context_and_work))

    # -- in each tick ------------------------------------------------------------------------------

    def move(self) -> None:
        builder, time = self.builder, self.frame.time
        context = self._context()
        for i, value in enumerate(self.numbers()):
            builder.store(self.x, i, value)
        step, *events = self.functions
        if self.fixed:
            with builder.counted(0, self.substeps, 1, "substep") as substep:
                number = builder.compute("float_of_integer", substep)
                at = builder.compute("add", time, builder.compute("multiply", number, self.length))
                builder.call(step, *leaves((context, at, self.length, self.x, self.x, self.error)))
        else:
            accuracy = (self.length, self.tolerance, operand(self.solver.order), self.precision)
            arrays = (self.x, self.moved, self.error, self.largest, self.begun, self.clear, self.side)
            numbers = operand(len(self.group.events)), operand(self.group.counts)
            given = (step, *events, context, time, self.writer.period, *accuracy, *arrays, *numbers)
            status = call(builder, integrate, (GroupTick._make(given),))
            large = builder.compute("multiply", 1e308, builder.compute("multiply", 10.0, status))
            self.writer.lose(builder.compute("multiply", 0.0, large))  # NaN where it failed
        self.keep([builder.load(self.x, i) for i in range(len(self.group.states))])

    def _context(self) -> Lowered:
        builder, frame = self.builder, self.frame
        inputs = {node: frame.wire(node) for node in self.group.inputs}
        slopes = []
        for node in self.group.ramps:
            change = builder.compute("subtract", self.writer.following[node], inputs[node])
            slopes.append(builder.compute("divide", change, self.writer.period))
        guesses = tuple(frame.wire(node) for node in self.group.guesses)
        made = (self.constants(), tuple(inputs.values()), tuple(slopes), guesses, frame.time, self.work())
        context = GroupContext(*made)
        return (context, self.largest, self.steps_work) if self.solver.method == "radau" else context

    # -- functions ---------------------------------------------------------------------------------

    def _explicit(self, context: GroupContext, rates: Function) -> Function:
        """Write the formula of the method: it runs on values that record their arithmetic."""
        builder = self.builder.beside(f"{self.name}_step", inline=self.fixed)
        given, time, length, x, moved, error = self._of_step(builder, context)

        def rates_at(at: WrittenNumber, there: list[WrittenNumber]) -> list[WrittenNumber]:
            found = builder.call(rates, *leaves(given), at.value, *(each.value for each in there))
            return [builder.number(rate) for rate in found]

        states = [builder.number(builder.load(x, i)) for i in range(len(self.group.states))]
        method = EXPLICIT[self.solver.method]
        result, *estimate = explicit_step(method, rates_at, builder.number(time), builder.number(length), states)
        for i, value in enumerate(result):
            builder.store(moved, i, value.value)
        for errors in estimate:
            for i, value in enumerate(errors):
                builder.store(error, i, value.value)
        return builder.function()

    def _radau(self, given: Lowered, rates: Function) -> Function:
        into = self._rates_into(given[0], rates)
        builder = self.builder.beside(f"{self.name}_step")
        at, time, length, x, moved, error = self._of_step(builder, given)
        call(builder, radau_step, (into, at[0], time, length, x, moved, error, at[1], at[2]))
        return builder.function()

    def _rates_into(self, context: GroupContext, rates: Function) -> Function:
        builder, size = self.builder.beside(f"{self.name}_rates_into"), len(self.group.states)
        parameters = parameters_like(builder, "at", context)
        time = builder.parameter(FLOAT, "time")
        x, out = builder.array(FLOAT, size, "x", True), builder.array(FLOAT, size, "out", True)
        states = [builder.load(x, i) for i in range(size)]
        for i, rate in enumerate(builder.call(rates, *leaves(parameters), time, *states)):
            builder.store(out, i, rate)
        return builder.function()

    def _of_step(self, builder: Builder, given: Lowered) -> Sequence[Lowered]:
        size = len(self.group.states)
        at = parameters_like(builder, "at", given)
        time, length = builder.parameter(FLOAT, "time"), builder.parameter(FLOAT, "length")
        arrays = [builder.array(FLOAT, size, name, True) for name in ("x", "moved", "error")]
        return at, time, length, *arrays

    def _clearances(self, given: Lowered) -> Function:
        builder = self.builder.beside(f"{self.name}_clearances")
        frame, _ = self._of_events(builder, given, "clear")
        clear = builder.parameters[-1]
        assert isinstance(clear, Storage)
        if frame is not None:
            watched = [(name, event, type(self.blocks[name]).events[event][0]) for name, event in self.group.events]
            watched += [(name, corner, type(self.blocks[name]).corners[corner]) for name, corner in self.group.corners]
            numbers = [as_kind(builder, frame.sound(frame.called(*each)), FLOAT) for each in watched]
            for i, number in enumerate(numbers):
                builder.store(clear, i, frame.unless_failed(number))
        return builder.function()

    def _then(self, given: Lowered) -> Function:
        builder = self.builder.beside(f"{self.name}_then")
        frame, x = self._of_events(builder, given, "")
        which = builder.parameters[-1]
        assert not isinstance(which, Storage)
        if frame is not None:
            for number, (name, event) in enumerate(self.group.events):
                with builder.when(builder.compute("equal_integers", which, number)):
                    made = frame.sound(frame.called(name, event, type(self.blocks[name]).events[event][1]))
                    for (field, _), value in zip(state_fields(self.blocks[name]), made, strict=True):
                        place = self.group.states.index((name, field))
                        builder.store(x, place, as_kind(builder, value, FLOAT))
            if frame.failed is not None:
                builder.store(x, 0, frame.unless_failed(builder.load(x, 0)))
        return builder.function()

    def _of_events(self, builder: Builder, given: Lowered, into: str) -> tuple[Frame | None, Storage]:
        """Parameters of a function of events, and the values known in it, if there are events."""
        at = parameters_like(builder, "at", given)
        time, size = builder.parameter(FLOAT, "time"), len(self.group.states)
        x = builder.array(FLOAT, size, "x", True)
        if into:
            builder.array(FLOAT, self.group.watched, into, True)
        else:
            builder.parameter(INTEGER, "which")
        context = at[0] if self.solver.method == "radau" else at
        if not self.group.watched:
            return None, x
        return self.instant(builder, context, time, [builder.load(x, i) for i in range(size)]), x
