"""Groups of continuous blocks in a program: their rates at an instant, and linear groups, which matrices move."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, Protocol

from proofmass.graphs.checks.schedule import ConstantsOf
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.continuous.exact_hold import (
    MANY_COLUMNS,
    UNIT,
    matrix_exponential,
    multiply,
    scale_rows,
    sum_rows,
)
from proofmass.runner.plan.groups import state_fields
from proofmass.runner.plan.keys import SolverNumber, variable
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.program.build import Builder, operand, parameters_like
from proofmass.runner.program.form import FLOAT, INTEGER, Function, Operand, Storage
from proofmass.runner.program.frame import Frame
from proofmass.runner.program.loops import LoopWriter
from proofmass.runner.program.lower import call
from proofmass.runner.program.lower_numbers import as_kind
from proofmass.runner.program.run_numbers import RunNumbers
from proofmass.runner.program.structure import Lowered, leaves


class WritesTick(Protocol):
    """The part of the tick's writer that a group needs."""

    plan: Plan
    builder: Builder
    frame: Frame
    period: Any
    following: dict[Endpoint, Operand]
    lanes: bool
    numbers: RunNumbers

    def renewing(self, matrix: Storage, followed: Sequence[Operand]) -> Operand:
        """Return whether a matrix is made anew though none of the numbers that it follows from has changed."""
        ...

    def value_of(self, name: str, function: str) -> Lowered:
        """Result of a function of a block; a fault in it is noted."""
        ...

    def lose(self, nothing: Operand) -> None:
        """Make the tick's check NaN from here on if a number is NaN; else the number is zero."""
        ...


class GroupContext(NamedTuple):
    """All that stays the same during a tick: constants by member, inputs, their slopes, guesses for loops."""

    constants: Lowered
    inputs: Lowered
    slopes: Lowered
    guesses: Lowered
    start: Lowered
    work: Lowered  # arrays of the loops


class GroupWriter:
    """Writes one group."""

    def __init__(self, writer: WritesTick, solver: Solver) -> None:
        self.writer, self.plan, self.frame, self.builder = writer, writer.plan, writer.frame, writer.builder
        self.solver, self.group, self.name = solver, solver.group, solver.name
        self.blocks = self.plan.blocks
        named = enumerate(self.group.loops)
        self.loops = [LoopWriter(loop, f"{self.name}_loop_{i}", writer.numbers.scratch) for i, loop in named]
        self.solved = {loop.tears[0]: loop for loop in self.loops}

    def begin(self) -> None:
        """Write what comes before the first tick."""
        raise NotImplementedError

    def move(self) -> None:
        """Move the states by one tick, in the order of the reference engine."""
        raise NotImplementedError

    # -- functions of an instant -------------------------------------------------------------------

    def rates(self, context: GroupContext) -> Function:
        """Derivatives of all states; modes stand still."""
        builder = self.builder.beside(f"{self.name}_rates", inline=not self.loops)
        given = parameters_like(builder, "at", context)
        time = builder.parameter(FLOAT, "time")
        x = [builder.parameter(FLOAT, f"x_{variable(state)}") for state in self.group.states]
        frame = self.instant(builder, given, time, x)
        rates: list[Operand] = []
        for name in self.group.blocks:
            fields = state_fields(self.blocks[name])
            if "derivative" not in type(self.blocks[name]).functions:
                rates += [operand(0.0)] * len(fields)
                continue
            made = frame.sound(frame.call(name, "derivative"))
            rates += [
                as_kind(builder, rate, FLOAT) if kind is float else operand(0.0)
                for rate, (_, kind) in zip(made, fields, strict=True)
            ]
        builder.give(*map(frame.unless_failed, rates))
        return builder.function()

    def instant(self, builder: Builder, context: GroupContext, time: Operand, x: Sequence[Operand]) -> Frame:
        """Arguments of all functions of the blocks at an instant."""
        frame = Frame(self.plan, builder)
        frame.time = time
        self._constants_within(frame, context.constants)
        frame.wires |= zip(self.group.inputs, context.inputs, strict=True)
        passed = builder.compute("subtract", time, context.start)
        for node, slope in zip(self.group.ramps, context.slopes, strict=True):
            moved = builder.compute("add", frame.wires[node], builder.compute("multiply", slope, passed))
            frame.wires[node] = moved
        frame.wires |= zip(self.group.guesses, context.guesses, strict=True)
        frame.states |= self.states(builder, x)
        for step in self.group.nodes:
            if isinstance(step, ConstantsOf):
                frame.constants[step.block] = frame.sound(frame.driven(step.block))
            elif step in self.solved:
                loop = self.solved[step]
                loop.solve(frame, context.work[self.loops.index(loop)])
            elif step not in self.group.guesses:
                frame.put(step, frame.sound(frame.call(*step)))
        return frame

    def states(self, builder: Builder, x: Sequence[Operand]) -> Iterator[tuple[str, Lowered]]:
        """Make the states of the blocks from floats."""
        kinds = {float: FLOAT, int: INTEGER}
        typed = iter(
            as_kind(builder, value, kinds[kind]) if kind in kinds else builder.compute("not_equal", value, 0.0)
            for value, kind in zip(x, self.group.kinds, strict=True)
        )
        for name in self.group.blocks:
            record: Any = type(self.blocks[name]).state_class()
            yield name, record._make(next(typed) for _ in record._fields)

    def keep(self, x: Sequence[Operand]) -> None:
        """Set the states of the blocks from floats."""
        for name, state in self.states(self.builder, x):
            self.frame.set(self.frame.states[name], state)
            if "fold" in type(self.blocks[name]).functions:
                self.frame.set(self.frame.states[name], self.writer.value_of(name, "fold"))

    def numbers(self) -> list[Operand]:
        """The states of the blocks as floats, in order."""
        held = (self.frame.now(getattr(self.frame.states[block], field)) for block, field in self.group.states)
        return [as_kind(self.builder, value, FLOAT) for value in held]

    # -- constants ---------------------------------------------------------------------------------

    def constants(self) -> Lowered:
        """Constants of the members, or the numbers from which the group computes them."""
        return tuple(self._constants_of(member) for member in self.group.members)

    def _constants_of(self, member: str) -> Lowered:
        frame = self.frame
        if ConstantsOf(member) not in self.group.nodes:
            return frame.now(frame.constants[member])
        made = tuple(frame.now(frame.parameters[member, p]) for p in self._settled(member))
        return (*made, frame.now(frame.periods[member]))

    def _settled(self, member: str) -> list[str]:
        """Parameters of a block that no wire drives."""
        record: Any = type(self.blocks[member]).parameters_class()
        return [p for p in record._fields if (member, p) not in self.plan.schedule.drivers]

    def _constants_within(self, frame: Frame, given: Lowered) -> None:
        for member, value in zip(self.group.members, given, strict=True):
            if ConstantsOf(member) not in self.group.nodes:
                frame.constants[member] = value
                continue
            *parameters, frame.periods[member] = value
            frame.parameters |= zip(((member, p) for p in self._settled(member)), parameters, strict=True)

    def work(self) -> Lowered:
        """The arrays of the loops."""
        return tuple(loop.arrays for loop in self.loops)

    def number(self, number: str, kind: type, value: float) -> Any:
        """A number that the stepping of the group uses."""
        return self.writer.numbers.constant(SolverNumber(self.name, number), kind, value)


class ExactGroup(GroupWriter):
    """A linear group, moved by matrices: x[n+1] = transition x[n] + entry (u[n], 1, change of ramps over the tick)."""

    def begin(self) -> None:
        self.own = len(self.group.states) + len(self.group.inputs) + self.solver.affine  # without those of ramps
        self.columns = self.own + len(self.group.ramps)
        self.large = self.columns > MANY_COLUMNS and not self.solver.renewed and not self.writer.lanes
        keys = ("matrix", "grown", "square", "scale")
        squared = [self.writer.numbers.scratch(f"{self.name}_{key}", self.columns * self.columns) for key in keys]
        self.matrix, self.grown, self.square, self.scale = squared
        self.context = self._still(self.constants(), self.group.inputs)
        self.assemble = self._assemble(self.rates(self.context))
        self.used = self.writer.numbers.scratch(f"{self.name}_used", len(self._followed()))
        if self.solver.renewed:
            return
        self._renew()
        places = 0 if self.large else len(self.group.states) * self.columns
        self.factors = [self.builder.load(self.matrix, place) for place in range(places)]

    def _still(self, constants: Lowered, inputs: Sequence[Any]) -> GroupContext:
        """Context in which nothing moves: the rates of unit states and inputs are computed."""
        zero = operand(0.0)
        still = (zero,) * len(self.group.ramps), (zero,) * len(self.group.guesses)
        return GroupContext(constants, (zero,) * len(inputs), *still, zero, self.work())

    def move(self) -> None:
        if self.solver.renewed:
            self._renew()
        first = self.solver.factors[:1]
        inputs = (operand(1.0) if node in first else self._input(node) for node in self.group.inputs)
        terms = [*self.numbers(), *inputs, *[operand(1.0)] * self.solver.affine]
        for node in self.group.ramps:
            terms.append(self.builder.compute("subtract", self.writer.following[node], self._input(node)))
        self.keep(self._by_rows(terms) if self.large else self._sums(terms))

    def _input(self, node: Endpoint) -> Operand:
        return as_kind(self.builder, self.frame.wire(node), FLOAT)

    def _sums(self, terms: Sequence[Operand]) -> list[Operand]:
        compute, moved = self.builder.compute, list[Operand]()
        for i in range(len(self.group.states)):
            total = compute("multiply", self._factor(i, 0), terms[0])
            for j, term in enumerate(terms[1:], 1):
                total = compute("add", total, compute("multiply", self._factor(i, j), term))
            moved.append(total)
        return moved

    def _by_rows(self, terms: Sequence[Operand]) -> list[Operand]:
        """Multiply row by row, with the same sums in the same order; the scratch of the assembly is free for it."""
        for j, term in enumerate(terms):
            self.builder.store(self.grown, j, term)
        rows = operand(len(self.group.states))
        call(self.builder, sum_rows, (self.matrix, self.grown, self.square, rows, operand(self.columns)))
        return [self.builder.load(self.square, i) for i in range(len(self.group.states))]

    def _factor(self, i: int, j: int) -> Operand:
        place = i * self.columns + j
        return self.builder.load(self.matrix, place) if self.solver.renewed else self.factors[place]

    def _followed(self) -> list[Operand]:
        """Constants and factors that the matrices follow from; if none moves, a mark that the matrices exist."""
        if not self.solver.renewed:
            return [operand(1.0)]
        members = [member for member in self.group.members if self.plan.is_driven(member)]
        constants = tuple(self.frame.now(self.frame.constants[member]) for member in members)
        numbers = [value for value in leaves(constants) if not isinstance(value, Storage)]
        numbers += [self.frame.wire(node) for node in self.solver.factors]
        return [as_kind(self.builder, value, FLOAT) for value in numbers]

    def _renew(self) -> None:
        """Compute the matrices again if a constant or factor behind them differs from the last tick or call."""
        builder, followed = self.builder, self._followed()
        moved = self.writer.renewing(self.matrix, followed) if self.solver.renewed else operand(False)
        for i, value in enumerate(followed):
            other = builder.compute("not_equal", value, builder.load(self.used, i))
            moved = builder.compute("either", moved, other)
        with builder.when(moved):
            for i, value in enumerate(followed):
                builder.store(self.used, i, value)
            self._assembled()

    def _assembled(self) -> None:
        arrays = (self.matrix, self.grown, self.square, self.scale)
        held = [self._input(node) for node in self.solver.factors]
        given = leaves((self._still(self.constants(), self.group.inputs), tuple(held)))
        self.builder.call(self.assemble, *given, self.writer.period, *arrays)

    def _assemble(self, rates: Function) -> Function:
        """Transition and entry from the rates for unit states and inputs."""
        builder = self.builder.beside(f"{self.name}_assemble")
        context = parameters_like(builder, "at", self.context)
        factors = [builder.parameter(FLOAT, f"factor_{i}") for i, _ in enumerate(self.solver.factors)]
        period = builder.parameter(FLOAT, "period")
        n, m, size = len(self.group.states), len(self.group.inputs), self.columns
        arrays = [builder.array(FLOAT, size * size, name, True) for name in ("matrix", "grown", "square", "scale")]
        matrix = arrays[0]
        with builder.counted(0, size * size, 1, "entry") as entry:
            builder.store(matrix, entry, 0.0)
        factor_columns = {
            n + self.group.inputs.index(node): f for node, f in zip(self.solver.factors, factors, strict=True)
        }

        def rates_at(point: Sequence[Any]) -> Sequence[Operand]:
            at = context._replace(inputs=tuple(point[n:]))
            return builder.call(rates, *leaves((at,)), 0.0, *point[:n])

        def rates_for(unit: int) -> Sequence[Operand]:
            return rates_at([factor_columns.get(i, operand(self.unit if i == unit else 0.0)) for i in range(n + m)])

        offset = rates_for(-1) if factor_columns or self.solver.affine else ()
        if self.large:
            self._columns(builder, arrays, rates_at, offset)
        for j in range(0 if self.large else self.own):
            if j in factor_columns and j != next(iter(factor_columns)):
                continue
            constant = j in factor_columns or j == n + m
            column = offset if constant else self._less(builder, rates_for(j), offset)
            for i, rate in enumerate(column):
                builder.store(matrix, i * size + j, rate)
        call(builder, scale_rows, (matrix, operand(n), operand(self.own), operand(size), period))
        for number, node in enumerate(self.group.ramps):
            builder.store(matrix, (n + self.group.inputs.index(node)) * size + self.own + number, 1.0)
        call(builder, matrix_exponential, (matrix, operand(size), *arrays[1:], multiply))
        return builder.function()

    @property
    def unit(self) -> float:
        """State or input for which rates are computed."""
        return UNIT if self.solver.affine else 1.0

    def _less(self, builder: Builder, rates: Sequence[Operand], offset: Sequence[Operand]) -> Sequence[Operand]:
        """Return the effect of a unit state or input, without that of a constant."""
        if offset:
            rates = [builder.compute("subtract", rate, c) for rate, c in zip(rates, offset, strict=True)]
        return [builder.compute("divide", rate, self.unit) for rate in rates] if self.solver.affine else rates

    def _columns(self, builder: Builder, arrays: Sequence[Storage], rates_at: Any, offset: Sequence[Operand]) -> None:
        """Columns in a loop, in the scratch of the matrix exponential."""
        matrix, grown, _, _ = arrays
        n, m = len(self.group.states), len(self.group.inputs)
        with builder.counted(0, n + m, 1, "column") as column:
            with builder.counted(0, n + m, 1, "entry") as entry:
                builder.store(grown, entry, 0.0)
            builder.store(grown, column, self.unit)
            rates = rates_at([builder.load(grown, i) for i in range(n + m)])
            for row, rate in enumerate(self._less(builder, rates, offset)):
                builder.store(matrix, builder.compute("add_integers", row * self.columns, column), rate)
        for row, rate in enumerate(offset):
            builder.store(matrix, row * self.columns + n + m, rate)
