"""The plan as a program: one function that runs a range of ticks on the memory passed to it.

The program reads numbers that a run may change (parameters, seed, state) from arrays; only what the
graph fixes (wiring, rate ratios, sizes, parameters that are true or false) is written into it.
"""

from collections.abc import Collection, Iterator, Sequence
from functools import partial
from typing import Any

from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.graphs.checks.schedule import Beat, ConstantsOf, outputs_of
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.statistics import STATISTICS
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.bindings import Binding, Tick, Time, WireBinding
from proofmass.runner.plan.keys import (
    BasePeriod,
    ConstantOf,
    OverflowsOf,
    ParameterOf,
    PeriodOf,
    StateField,
    StreamOf,
    WireOf,
    variable,
    word,
)
from proofmass.runner.plan.planned import Driven, Plan
from proofmass.runner.program.build import Builder, operand
from proofmass.runner.program.digital import DigitalWriter
from proofmass.runner.program.due import DueStep, when_due
from proofmass.runner.program.form import FLOAT, INTEGER, Function, Operand, Storage
from proofmass.runner.program.frame import Frame, entries
from proofmass.runner.program.groups import GroupWriter
from proofmass.runner.program.loops import LoopWriter
from proofmass.runner.program.lower import Called, call, program
from proofmass.runner.program.lower_numbers import KINDS, nan
from proofmass.runner.program.probes import ProbeWriter
from proofmass.runner.program.run_numbers import RunNumbers
from proofmass.runner.program.slots import fields
from proofmass.runner.program.stepped import group_writer
from proofmass.runner.program.structure import Lowered, mapped
from proofmass.runner.program.tick_loop import TickLoop, settled_before, vectors_of
from proofmass.runner.program.watched import watched


def write_tick(plan: Plan, varied: Collection[Endpoint] = (), lanes: bool = False, measured: bool = False) -> TickLoop:
    """Return the program of a plan. It computes the constants of blocks with `varied` parameters
    before the first tick.

    With `measured`, or `lanes` (runs side by side), wires of measures hold their values after the
    last tick.
    """
    return TickWriter(plan, varied, lanes, measured or lanes).written()


class TickWriter:
    """Writes the function of all ticks, with a writer for each part of it."""

    def __init__(
        self, plan: Plan, varied: Collection[Endpoint] = (), lanes: bool = False, measured: bool = False
    ) -> None:
        self.plan, self.lanes, self.measured = plan, lanes, measured
        self.varied = {name for name, _ in varied} - settled_before(plan, varied)
        self.builder = Builder("loop", f"{len(plan.blocks)} blocks")
        self.frame = Frame(plan, self.builder)
        self.vectors = dict(vectors_of(plan))
        self.first, self.last, self.seed, self.run = (
            self.builder.parameter(INTEGER, name) for name in ("first", "last", "seed", "run")
        )
        self.numbers = RunNumbers(self.builder, lanes)
        self.digital = DigitalWriter(self.frame, self.numbers.refused)
        for node, (kind, length) in self.vectors.items():
            entry = FLOAT if kind is float else INTEGER
            array = self.builder.array(entry, length, variable(node), node not in plan.recorded)
            self.frame.wires[node] = array
        self.probes = [
            self.builder.array(KINDS[probe.dtype], None, f"probe_{number}", True)
            for number, probe in enumerate(plan.probes)
        ]

    def renewing(self, matrix: Storage, followed: Sequence[Operand]) -> Operand:
        """Return whether a matrix of a group is made anew though none of the numbers that it
        follows from has changed."""
        return operand(False)

    def written(self) -> TickLoop:
        """Write the whole function."""
        numbers = self.numbers
        entry = numbers.complete(self._entry())
        return TickLoop(
            program(entry),
            numbers.constants,
            numbers.values,
            numbers.memory,
            tuple(self.vectors),
            tuple(kind for kind, _ in self.vectors.values()),
            numbers.scratch_used,
        )

    def _entry(self) -> Function:
        builder = self.builder
        self.period = self.numbers.constant(BasePeriod(), float, self.plan.period)
        self.begin()
        probes = ProbeWriter(self.plan, self.frame, self.probes, self.first)
        self.check_constants()
        with builder.counted(self.first, self.last, 1, "tick") as tick:
            self.frame.tick = tick
            number = builder.compute("float_of_integer", tick)
            self.frame.time = builder.compute("multiply", number, self.period, name="time")
            self.outputs()
            probes.record()
            self.updates()
            self.move()
        self.finish()
        return builder.function()

    # -- before the ticks --------------------------------------------------------------------------

    def begin(self) -> None:
        """Write what the loop reads before the first tick."""
        plan, frame = self.plan, self.frame
        self.checks: list[Called] = []  # constants that a run alone would refuse
        for name in plan.blocks:
            self.constants_of(name)
        self.loops = [LoopWriter(loop, f"loop_{i}", self.numbers.scratch) for i, loop in enumerate(plan.schedule.loops)]
        for name, block in plan.blocks.items():
            state: Any = type(block).state_class()
            if state is not None:
                kept = ((StateField(name, f), held_as(k), f) for f, k in fields(state))
                frame.states[name] = state._make(
                    self.numbers.variable(key, kind, f"{word(name)}_{f}") for key, kind, f in kept
                )
            for port, output in type(block).outputs.items():
                if not output.shape:
                    key = WireOf(name, port)
                    frame.wires[name, port] = self.numbers.variable(key, held_as(output.dtype), variable((name, port)))
        for name in plan.blocks:
            if plan.is_driven(name):
                frame.constants[name] = self._variables_like(name)
        for name in self.digital.counted:
            self.digital.counts[name] = self.numbers.variable(OverflowsOf(name), int, f"{word(name)}_overflows")
        self.groups: list[GroupWriter] = [group_writer(self, solver) for solver in plan.solvers]
        for group in self.groups:
            group.begin()

    def constants_of(self, name: str) -> None:
        """Constants of a block: given numbers, or variables that are computed from parameters."""
        block, values = self.plan.blocks[name], self.plan.constants[name]
        if isinstance(values, Driven):
            self._parameters_of(name)
        elif name in self.varied and "constants" in type(block).functions:
            self._parameters_of(name)
            self.checks.append(self.frame.driven(name))
            self.frame.constants[name] = self.checks[-1].value
        else:
            made, of_run = type(values), "constants" in type(block).functions
            of = ((ConstantOf(name, f), k, v) for (f, k), v in zip(fields(made), values, strict=True))
            self.frame.constants[name] = made._make(
                operand(v) if k is bool and not of_run else self.numbers.constant(key, k, v) for key, k, v in of
            )

    def _variables_like(self, name: str) -> Lowered:
        """Variables for constants that the tick computes."""
        with self.builder.within([]):
            made = self.frame.driven(name).value
        return mapped(made, lambda leaf: self.builder.variable(leaf.kind, f"{word(name)}_constant"))

    def _parameters_of(self, name: str) -> None:
        plan, block = self.plan, self.plan.blocks[name]
        for p, kind in fields(type(block).parameters_class()):
            if (name, p) not in plan.schedule.drivers:
                key, value = ParameterOf(name, p), getattr(block, p)
                known = operand(value) if kind is bool else self.numbers.constant(key, held_as(kind), value)
                self.frame.parameters[name, p] = known
        self.frame.periods[name] = self.numbers.constant(PeriodOf(name), float, plan.block_period(name))

    def check_constants(self) -> None:
        """Note faults in constants from varied parameters, and constants that are not finite."""
        for made in self.checks:
            self.fault(made)
            for value in made.value:
                if getattr(value, "kind", None) is FLOAT:
                    self.look_at(value)

    # -- the parts of a tick, in their order -------------------------------------------------------

    def outputs(self) -> None:
        """Compute all outputs of a tick."""
        plan, builder = self.plan, self.builder
        self.digital.begin_tick()
        drawn: set[str] = set()
        looked_at = watched(plan)
        for name, block in plan.blocks.items():
            kind = type(block)
            if any(map(draws, (*kind.output_functions.values(), *kind.functions.values()))):
                self.frame.deviates[name] = builder.variable(FLOAT, f"{word(name)}_normal")
        when_due(self.frame, self._in_order(drawn, looked_at))
        updating = ((name, type(block).functions.get("update")) for name, block in plan.blocks.items())
        late = [name for name, update in updating if update is not None and draws(update) and name not in drawn]
        when_due(self.frame, ((plan.schedule.beat(name), partial(self.draw, name)) for name in late))
        due = (node for node in outputs_of(plan.schedule.order) if node in looked_at and plan.stride(node) == 1)
        numbers = [entry for node in due for entry in entries(builder, self.frame.wire(node))]
        if numbers:
            total: Operand = numbers[0]
            for number in numbers[1:]:
                total = builder.compute("add", total, number)
            self.look_at(total)

    def _in_order(self, drawn: set[str], looked_at: Collection[Endpoint]) -> Iterator[tuple[Beat, DueStep]]:
        """Steps that compute the outputs in order, each with its beat."""
        plan = self.plan
        solved = {loop.tears[0]: loop for loop in self.loops}
        tears = {tear for loop in self.loops for tear in loop.tears}
        for step in plan.schedule.order:
            if isinstance(step, ConstantsOf):
                yield plan.schedule.beat(step.block), partial(self.driven, step.block)
                continue
            name, port = step
            block, beat = plan.blocks[name], plan.beat((name, port))
            if draws(type(block).output_functions[port]) and name not in drawn:
                drawn.add(name)
                yield beat, partial(self.draw, name)
            if (name, port) in solved:
                yield beat, partial(solved[name, port].solve, self.frame)
            elif (name, port) not in tears:
                yield beat, partial(self.output, name, port)
            if type(block).outputs[port].dtype is FixedValue and not type(block).has_formats():
                yield beat, partial(self.digital.hold, (name, port))
            if (name, port) in looked_at and beat.stride > 1:
                yield beat, partial(self._look_at_wire, (name, port))

    def output(self, name: str, port: str) -> None:
        """Compute an output of a block."""
        value = self.value_of(name, port)
        if not type(self.plan.blocks[name]).outputs[port].shape:
            self.frame.set(self.frame.wires[name, port], value)

    def value_of(self, name: str, function: str) -> Lowered:
        """Result of a function of a block; a fault in it is noted."""
        if name in self.plan.digital:
            return self.digital.call(name, function)
        return self.fault(self.frame.call(name, function))

    def fault(self, called: Called) -> Lowered:
        """Note a fault, which ends the run."""
        if called.fault is not None:
            builder = self.builder
            number = builder.compute("integer_of_truth", called.fault)
            builder.set(self.numbers.refused, builder.compute("or", builder.get(self.numbers.refused), number))
        return called.value

    def look_at(self, value: Operand) -> None:
        """Make the tick's check NaN from here on if a number is not finite."""
        self.lose(self.builder.compute("subtract", value, value))

    def lose(self, nothing: Operand) -> None:
        """Make the tick's check NaN from here on if a number is NaN; else the number is zero."""
        total = self.builder.compute("add", self.builder.get(self.numbers.not_finite), nothing)
        self.builder.set(self.numbers.not_finite, total)

    def _look_at_wire(self, node: Endpoint) -> None:
        for entry in entries(self.builder, self.frame.wire(node)):
            self.look_at(entry)

    def driven(self, name: str) -> None:
        """Compute the constants of a block from the signals that drive its parameters, and check their bounds."""
        drivers = self.plan.schedule.drivers
        for p, declared in type(self.plan.blocks[name]).parameters.items():
            if (name, p) in drivers:
                self._within(self.frame.wire(drivers[name, p]), declared)
        self.frame.set(self.frame.constants[name], self.fault(self.frame.driven(name)))

    def _within(self, value: Operand, declared: Any) -> None:
        builder = self.builder
        limits = [(declared.above, "less", True), (declared.at_least, "less_equal", True)]
        limits += [(declared.below, "less", False), (declared.at_most, "less_equal", False)]
        for limit, operation, above in limits:
            if limit is not None:
                pair = (float(limit), value) if above else (value, float(limit))
                self.lose(builder.compute("select", builder.compute(operation, *pair), 0.0, nan()))

    def draw(self, name: str) -> None:
        """Draw a fresh normal deviate for a block."""
        stream = self.numbers.constant(StreamOf(name), int, self.plan.stream(name))
        sample = self.frame.ticks(self.plan.schedule.beat(name))
        made = call(self.builder, normal_deviate, (self.seed, self.run, stream, sample))
        self.builder.set(self.frame.deviates[name], made)

    def updates(self) -> None:
        """Update the states of discrete blocks."""
        beat = self.plan.schedule.beat
        names = (name for name, block in self.plan.blocks.items() if "update" in type(block).functions)
        when_due(self.frame, ((beat(name), partial(self.update, name)) for name in names))
        self.digital.end_tick()

    def update(self, name: str) -> None:
        """Update the state of a block."""
        value = self.value_of(name, "update")
        if type(self.plan.blocks[name]).state_class() is not None:
            self.frame.set(self.frame.states[name], value)

    def move(self) -> None:
        """Move continuous groups to the next tick; the next values of sources that ramp are computed before."""
        builder, frame, plan = self.builder, self.frame, self.plan
        self.following: dict[Endpoint, Operand] = {}
        if plan.ahead:
            later = builder.compute("float_of_integer", builder.compute("add_integers", frame.tick, 1))
            after = builder.compute("multiply", later, self.period, name="time_next")

            def argument(binding: Binding) -> Lowered:
                match binding:
                    case Time():
                        return after
                    case WireBinding(node):
                        return self.following[node]
                return frame.argument(binding)

            for name, port in plan.ahead:
                made = frame.called(name, port, type(plan.blocks[name]).output_functions[port], argument)
                self.following[name, port] = frame.number(made)
        for group in self.groups:
            self.move_group(group)

    def move_group(self, group: GroupWriter) -> None:
        """Move a continuous group to the next tick."""
        group.move()

    def finish(self) -> None:
        """Write what comes after the last tick, before the memory is written back."""
        if self.measured:
            self.measure()

    def measure(self) -> None:
        """Compute the measures after the last tick, each in the place of its wire."""
        frame = self.frame
        for (name, port), statistic in {m.node: m.statistic for m in self.plan.measures if m.reduced}.items():
            beat = self.plan.schedule.beat(name)
            last = self.builder.compute("subtract_integers", beat.phase, self.last)
            frame.tick = self.builder.compute(
                "subtract_integers", 0, self.builder.compute("floor_divide", last, beat.stride)
            )
            made, defined = self._measured(name, port).value, STATISTICS[statistic].defined
            if defined:
                made = self.builder.compute("select", self._measured(name, defined).value, made, nan())
            frame.set(frame.wires[name, port], made)

    def _measured(self, name: str, port: str) -> Called:
        """Compute an output of a hidden block."""
        function = type(self.plan.blocks[name]).output_functions[port]
        return self.frame.called(name, port, function, self._at_the_end)

    def _at_the_end(self, binding: Binding) -> Lowered:
        return self.frame.tick if isinstance(binding, Tick) else self.frame.argument(binding)


def draws(behaviour: Behaviour) -> bool:
    """Return whether a function takes a normal deviate."""
    return Meaning.DEVIATE in behaviour.meanings
