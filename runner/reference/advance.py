"""Continuous groups from one tick to the next in plain Python, as the reference engine does it."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from proofmass.blocks.arithmetic.modes import Matrix
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.continuous.algebraic import NoSolutionError
from proofmass.runner.continuous.integrate import (
    DONE,
    MOST_EVENTS,
    MOST_SHORT,
    SHORT,
    STEPS_TOO_MANY,
    STEPS_TOO_SHORT,
    GroupTick,
    integrate,
)
from proofmass.runner.continuous.methods import EXPLICIT, explicit_step
from proofmass.runner.continuous.radau import radau_step, scratch
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.rates import assemble
from proofmass.runner.plan.solver import Solver
from proofmass.runner.plan.stages import StageContext, Stages

SLIDING = "take a Saturation of some slope, or a Relay with hysteresis, or equal steps: substeps = 100"
ABOVE_ROUNDING = 1e-12  # tolerance from which rounding alone refuses no step


class IntegrationError(ArithmeticError):
    """A group that could not be moved to the next tick: `at` is what failed."""

    def __init__(self, at: str, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.at, self.hint = at, hint


class TooOftenError(IntegrationError):
    """Endless steps or events: to look for an output that has no value would take as long again."""


class Moment(NamedTuple):
    """Starting point of a group's tick; `following` are the next values of the ramps."""

    constants: Mapping[str, Any]
    states: Mapping[str, Any]
    wires: Mapping[Endpoint, Any]
    following: Mapping[Endpoint, float]
    time: float


class Advance(ABC):
    """Moves the states of one group by a tick, in whatever numbers its stages take."""

    stages: Stages

    @abstractmethod
    def __call__(self, moment: Moment) -> dict[str, Any]:
        """Return the states of the group's blocks one tick later."""

    def lost(self, moment: Moment) -> str:
        """Return the output within the group that was the first to have no value in a tick that failed, or ""."""
        return ""


class PlainAdvance(Advance):
    """Moves the states of one group by its method."""

    def __init__(self, plan: Plan, solver: Solver, largest: Sequence[float]) -> None:
        self.solver, self.period, self.largest = solver, plan.period, largest
        self.stages = Stages(plan.blocks, plan.schedule, solver.group, plan.block_period)
        group, size = solver.group, len(solver.group.states)
        self._error = [0.0] * size
        functions = self._step, self.stages.clearances, self.stages.then
        numbers = plan.period / solver.substeps, solver.allowed, solver.order, solver.precision
        sides = [0.0] * group.watched, [0.0] * group.watched
        arrays = [0.0] * size, self._error, largest, [0.0] * (2 * size), *sides
        counts = len(group.events), group.counts
        self._tick = GroupTick._make((*functions, None, 0.0, plan.period, *numbers, [], *arrays, *counts))
        self._work = tuple([0.0] * length for length in scratch(size))
        self._matrices: tuple[Matrix, Matrix] = [], []
        self._assembled_from: list[Any] | None = None
        self._stepped: tuple[StageContext, list[float]] | None = None  # what the last tick was stepped from and how far

    def __call__(self, moment: Moment) -> dict[str, Any]:
        """Return the states of the group's blocks one tick later."""
        constants, states, wires, following, time = moment
        group = self.solver.group
        x = [float(getattr(states[block], field)) for block, field in group.states]
        inputs = [wires[node] for node in group.inputs]
        changes = [following[node] - wires[node] for node in group.ramps]
        self.stages.unsolved = ""
        if self.solver.exact:
            held = {node: wires[node] for node in self.solver.factors}
            first = self.solver.factors[:1]
            inputs = [1.0 if node in first else value for node, value in zip(group.inputs, inputs, strict=True)]
            one = [1.0] if self.solver.affine else []
            x = self._by_matrices(constants, held, [*x, *inputs, *one, *changes])
            self._check(DONE, x)
            return self.stages.states(x)
        guesses = [wires[node] for node in group.guesses]
        context = StageContext(constants, inputs, [change / self.period for change in changes], guesses, time)
        self._stepped = context, x
        self._check(self._by_steps(context, x), x)
        return self.stages.states(x)

    def lost(self, moment: Moment) -> str:
        """Return the output within the group that was the first to have no value in a tick that failed, or "".

        Steps may get too short just before that instant: then it is the first that has none a tick
        further on.
        """
        self.stages.watching, self.stages.lost = True, ""
        with suppress(ArithmeticError, ValueError):
            self(moment)
        with suppress(ArithmeticError, ValueError):
            if self._stepped is not None and not self.stages.lost:
                context, x = self._stepped
                rates = [0.0] * len(x)
                self.stages.rates(context, moment.time, x, rates)
                further = [v + self.period * rate for v, rate in zip(x, rates, strict=True)]
                self.stages.rates(context, moment.time, further, rates)
        self.stages.watching = False
        return self.stages.lost

    def _by_matrices(
        self, constants: Mapping[str, Any], held: Mapping[Endpoint, float], values: Sequence[float]
    ) -> list[float]:
        transition, entry = self.matrices(constants, held)
        moved = []
        for row, more in zip(transition, entry, strict=True):
            total = row[0] * values[0]
            for factor, value in zip((*row[1:], *more), values[1:], strict=True):
                total = total + factor * value
            moved.append(total)
        return moved

    def matrices(self, constants: Mapping[str, Any], factors: Mapping[Endpoint, float]) -> tuple[Matrix, Matrix]:
        """The matrices of a linear group, made anew when a driven parameter or factor moved."""
        if self.solver.renewed or self._assembled_from is None:
            used = [constants[name] for name in self.solver.group.members] + list(factors.values())
            if used != self._assembled_from:
                self._matrices = assemble(self.stages, constants, self.period, factors, self.solver.affine)
                self._assembled_from = used
        return self._matrices

    def _by_steps(self, context: StageContext, x: list[float]) -> float:
        """Moves the states; returns what `integrate` does."""
        solver = self.solver
        length = self.period / solver.substeps
        if not solver.tolerance and not solver.group.watched:
            for substep in range(solver.substeps):
                self._step(context, context.start + substep * length, length, x, x, self._error)
                if not all(map(math.isfinite, x)):  # nor will it be after the steps that are left
                    break
            return DONE
        return integrate(self._tick._replace(context=context, start=context.start, x=x))

    def _check(self, status: float, x: Sequence[float]) -> None:
        """Raise what kept the group from the next tick."""
        if self.stages.unsolved and not (status == DONE and all(map(math.isfinite, x))):
            raise NoSolutionError(self.stages.unsolved)
        solver = self.solver
        if status == STEPS_TOO_SHORT:
            at = f"{solver.group.blocks[0]}.derivative"
            message = "no step is short enough for the accuracy"
            if solver.tolerance < ABOVE_ROUNDING:
                hint = f"accuracy = {solver.tolerance:g} is below what rounding leaves of these numbers: ask for 1e-12"
                raise IntegrationError(at, message, hint)
            raise IntegrationError(at, f"{message}: the solution may not exist beyond this instant")
        if status == STEPS_TOO_MANY:
            raise self._too_many()
        if status != DONE:
            raise self._too_often(int(status) - 1)

    def _too_often(self, which: int) -> IntegrationError:
        """Return what an event or a corner does again and again: `which` counts all of them, and then once more."""
        group = self.solver.group
        watched = (*group.events, *group.corners)
        at = ".".join(watched[which % len(watched)])
        if which < len(watched):
            again = "the event happens again and again at one instant"
            return IntegrationError(at, f"{again}: its clearance is not above zero afterwards")
        if which - len(watched) < len(group.events):
            often = f"more than {MOST_EVENTS:,} events in a tick"
            return TooOftenError(at, often, "take more hysteresis, a smaller event_tolerance or a higher rate")
        return TooOftenError(at, "the motion slides along a jump, which it crosses without end", SLIDING)

    def _too_many(self) -> IntegrationError:
        """Return what asks for steps without end."""
        group = self.solver.group
        message = f"{MOST_SHORT:,} steps that are each shorter than {SHORT:g} of a tick: it would not end"
        hint = 'ask for less accuracy or a higher rate; method = "radau" where the group is stiff'
        if group.corners:
            jumps = ", ".join(map(".".join, group.corners))
            hint += f"; if the motion slides along a jump ({jumps}), {SLIDING}"
        return IntegrationError(f"{group.blocks[0]}.derivative", message, hint)

    def _step(self, context: StageContext, time: float, length: float, x: Any, moved: Any, error: Any) -> None:
        if self.solver.method not in EXPLICIT:
            radau_step(self.stages.rates, context, time, length, x, moved, error, self.largest, self._work)
            return

        def rates(at: float, there: list[float]) -> list[float]:
            out = [0.0] * len(there)
            self.stages.rates(context, at, there, out)
            return out

        result = explicit_step(EXPLICIT[self.solver.method], rates, time, length, x)
        moved[:] = result[0]
        if len(result) > 1:
            error[:] = result[1]
