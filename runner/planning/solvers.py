"""Choice of a solver for each group of continuous blocks: exact if its rates are linear but for a constant,
otherwise in steps.
"""

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any

from proofmass.blocks.arithmetic.modes import Matrix
from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.schedule import outputs_of
from proofmass.graphs.model.changes import changed_blocks
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.graphs.model.integration import MOST_SUBSTEPS
from proofmass.runner.continuous.linearity import factors_of
from proofmass.runner.continuous.methods import EXPLICIT
from proofmass.runner.plan.constants import constants_of
from proofmass.runner.plan.groups import Group, find_groups
from proofmass.runner.plan.planned import Driven, Filled
from proofmass.runner.plan.rates import rates_at
from proofmass.runner.plan.solver import Solver
from proofmass.runner.plan.stages import Stages

FirstTick = Callable[[], tuple[Mapping[str, Any], Mapping[Endpoint, Any]]]  # constants and wires

STIFF = 250  # time constants in a tick, from which on an implicit method is chosen
MOST_FIRST = 100  # first steps of an implicit method in a tick
PRECISION = 1e-12  # of the time of an event, in ticks
_OTHERS = (1.0, 1e-3, 1e-6, 1e-9, -1.0, -1e-3)  # numbers for parameters that are zero as set, the first that fits


def find_solvers(
    plan: Filled, constants: Mapping[str, Any], first_tick: FirstTick, free: AbstractSet[str] = frozenset()
) -> tuple[Solver, ...]:
    """Choose a solver for every group of a plan; `constants` are those of the parameters as set.

    The method of a group holds for any number of the parameters that are `free` or that wires
    drive.
    """
    groups = find_groups(plan.graph, plan.schedule)
    changing = free | {".".join(target) for target in plan.schedule.drivers}
    return tuple(
        _Choice(plan, group, constants, first_tick, changing).solver(f"group_{number}")
        for number, group in enumerate(groups)
    )


class _Choice:
    """Chooses the method of one group, by the graph's settings and tests of its functions."""

    def __init__(
        self,
        plan: Filled,
        group: Group,
        constants: Mapping[str, Any],
        first_tick: FirstTick,
        changing: AbstractSet[str],
    ) -> None:
        self.plan, self.group, self.constants, self.first_tick = plan, group, constants, first_tick
        self.changing = changing
        self.stages = Stages(plan.blocks, plan.schedule, group, plan.block_period)
        self.period, self.says = plan.period, plan.graph.integration
        self.start = [float(getattr(plan.starts[name], field)) for name, field in group.states]
        self.driven = any(plan.is_driven(member) for member in group.members)
        self.factors: tuple[Endpoint, ...] = ()
        self.affine = False

    def solver(self, name: str) -> Solver:
        method, substeps = self._method()
        adaptive = method in ("dormand_prince", "radau")
        precision = self.says.event_tolerance or PRECISION * self.period
        tolerance = self.says.accuracy if adaptive else 0.0
        factors = self.factors if method == "exact" else ()
        affine = self.affine and method == "exact"
        return Solver(name, self.group, method, substeps, tolerance, precision, self.driven, factors, affine)

    def _method(self) -> tuple[str, int]:
        method = self.says.method
        if method in ("auto", "exact"):
            reason = self._not_linear()
            if not reason:
                return "exact", 1
            if method == "exact":
                raise self._refused(f"cannot be stepped exactly: {reason}", 'leave out method = "exact"')
        if self.says.substeps is not None:
            return "runge_kutta_4" if method == "auto" else method, self.says.substeps
        fastest = self._fastest()
        if method == "auto":
            method = "radau" if self.period * fastest > STIFF else "dormand_prince"
        fastest = max(fastest, self._frequency())
        substeps = self._substeps(fastest, EXPLICIT["runge_kutta_4" if method == "radau" else method].order)
        if substeps > MOST_SUBSTEPS and method != "radau":
            hint = 'choose method = "radau", a lower accuracy or a higher rate'
            raise self._refused(f"needs {substeps:.3g} sub-steps in each tick", hint)
        return method, min(substeps, MOST_FIRST) if method == "radau" else substeps

    def _fastest(self) -> float:
        """The rate of the fastest time constant in tick 0."""
        fastest = spectral_radius(self._jacobian())
        if not math.isfinite(fastest):
            raise self._refused("its derivatives at the start are not finite", "look for a parameter that is far off")
        return fastest

    def _frequency(self) -> float:
        """The highest frequency that an output names, in rad/s: steps that pass over whole periods would not see it."""
        blocks, drivers = self.plan.blocks, self.plan.schedule.drivers
        names = sorted({name for name, _ in outputs_of(self.group.nodes)})
        named = [(n, p) for n in names for p, d in type(blocks[n]).parameters.items() if d.unit == "Hz"]
        values = [getattr(blocks[n], p) for n, p in named if (n, p) not in drivers]
        values += [self.first_tick()[1][drivers[place]] for place in named if place in drivers]
        return 2.0 * math.pi * max((abs(value) for value in values if isinstance(value, float)), default=0.0)

    def _substeps(self, fastest: float, order: int) -> int:
        """Sub-steps for which the error per time constant, (h / time constant)^order / (order + 1)!, is as wanted."""
        length: float = (self.says.accuracy * math.factorial(order + 1)) ** (1.0 / order)
        return max(1, math.ceil(self.period * fastest / length))

    def _jacobian(self) -> Matrix:
        """Derivatives of the rates by the states in tick 0: from dual numbers, by differences through a loop."""
        # start-up time: only groups of continuous blocks need slopes
        from proofmass.runner.derivatives.dual import SIGNALS, dual, slopes_of
        from proofmass.runner.derivatives.dual_groups import DualStages

        constants, wires = self.first_tick()
        constants = {
            name: self.constants[name] if isinstance(made, Driven) else made for name, made in constants.items()
        }
        inputs = [wires[node] for node in self.group.inputs]
        if self.group.loops:
            return self._slopes(lambda states: rates_at(self.stages, constants, [*states, *inputs], wires), 1.0, -1.0)
        point = [*(value + dual(0.0, {j: 1.0}, SIGNALS) for j, value in enumerate(self.start)), *inputs]
        stages = DualStages(self.plan, self.group, by_parameters=False)
        try:
            rates = rates_at(stages, constants, point, wires)
        except (TypeError, AttributeError, ArithmeticError) as error:
            raise self._refused(
                f"has no derivative at the start: {error}", "say substeps = 8, or method = ..."
            ) from None
        slopes = [[slopes_of(rate, SIGNALS).get(j, 0.0) for j in range(len(self.start))] for rate in rates]
        if all(math.isfinite(slope) for row in slopes for slope in row):
            return slopes
        return self._steepest(lambda states: rates_at(self.stages, constants, [*states, *inputs], wires))

    def _slopes(self, rates: Callable[[list[float]], list[float]], above: float, below: float) -> Matrix:
        """Slopes by differences between points about the start, at parts of a small step."""
        columns = []
        for j, value in enumerate(self.start):
            nudge = 1e-6 * abs(value) or 1e-12
            here, there = (rates([*self.start[:j], value + p * nudge, *self.start[j + 1 :]]) for p in (below, above))
            columns.append([(a - b) / ((above - below) * nudge) for a, b in zip(there, here, strict=True)])
        return [list(row) for row in zip(*columns, strict=True)]

    def _steepest(self, rates: Callable[[list[float]], list[float]]) -> Matrix:
        """Slopes on the steeper side of each corner; not finite if a slope is infinite and grows with smaller steps."""
        sides = []
        for part in (1.0, 0.01):
            both = zip(self._slopes(rates, part, 0.0), self._slopes(rates, -part, 0.0), strict=True)
            sides.append([[max(pair, key=abs) for pair in zip(*rows, strict=True)] for rows in both])
        wide, narrow = sides
        return [
            [b if abs(b) <= 2.0 * abs(a) else math.inf for a, b in zip(*rows, strict=True)]
            for rows in zip(wide, narrow, strict=True)
        ]

    def _not_linear(self) -> str:
        """Return why the rates are not linear in states and inputs but for a constant, for held factors, if so."""
        blocks = self.plan.blocks
        nonlinear = [
            name
            for name in self.group.blocks
            if "derivative" in type(blocks[name]).functions and not type(blocks[name]).linear
        ]
        if nonlinear:
            return f"{_listed(nonlinear)} not linear"
        if self.group.events:
            return f"{_listed(sorted({name for name, _ in self.group.events}))} subject to events"
        if any(Meaning.TIME in _meanings(blocks, *node) for node in outputs_of(self.group.nodes)) or any(
            Meaning.TIME in type(blocks[name]).functions["derivative"].meanings for name in self.group.blocks
        ):
            return "a function of it depends on the time"
        size = len(self.group.states) + len(self.group.inputs)
        first = len(self.group.states)
        held = [first + n for n, node in enumerate(self.group.inputs) if node not in self.group.ramps]
        at = self._rates()
        factors = factors_of(at, size, held) if at else None
        if at is None or factors is None:
            return f"the derivatives of {', '.join(self.group.members)} are not linear in states and inputs"
        self.factors = tuple(self.group.inputs[place - first] for place in factors)
        self.affine = not factors and any(at([0.0] * size))
        return ""

    def _rates(self) -> Callable[[Sequence[float]], list[float]] | None:
        """Return the rates of states and inputs, parameters that may change being other than zero; None without."""
        constants, zeros = dict(self.constants), dict[str, list[str]]()
        for name in self.changing:
            owner, parameter = split(name)
            if owner in self.group.members and _is_zero(self.plan.blocks[owner], parameter):
                zeros.setdefault(owner, []).append(name)
        blocks = dict(self.plan.blocks)
        for owner, names in zeros.items():
            for value in _OTHERS:
                try:
                    (block,) = changed_blocks(blocks, dict.fromkeys(names, value)).values()
                    constants[owner] = constants_of(block, block, self.plan.block_period(owner))
                except (ModelError, ArithmeticError, ValueError):
                    continue
                blocks[owner] = block
                break
            else:
                return None
        stages = Stages(blocks, self.plan.schedule, self.group, self.plan.block_period) if zeros else self.stages
        return lambda point: rates_at(stages, constants, point)

    def _refused(self, message: str, hint: str) -> ModelError:
        first = self.group.blocks[0]
        named = ", ".join(self.group.blocks)
        problem = Problem(message=f"{named}: {message}", hint=hint, path=("blocks", first))
        return self.plan.graph.placed(problem).error


def spectral_radius(matrix: Matrix) -> float:
    """Largest magnitude of an eigenvalue, from the norm of the 1024th power: at most a few per cent too large."""
    power, logarithm = [row[:] for row in matrix], 0.0
    for squaring in range(11):
        norm = max((sum(map(abs, row)) for row in power), default=0.0)
        if norm == 0.0 or not math.isfinite(norm):
            return norm
        logarithm += math.log(norm)
        if squaring < 10:
            scaled = [[v / norm for v in row] for row in power]
            columns = list(zip(*scaled, strict=True))
            power = [[math.fsum(map(operator.mul, row, column)) for column in columns] for row in scaled]
            logarithm *= 2.0
    return math.exp(logarithm / 1024.0)


def _is_zero(block: Block, parameter: str) -> bool:
    """Return whether a parameter, or an entry of one, is zero."""
    whole, _, index = parameter.partition("[")
    value: Any = getattr(block, whole, None)
    return bool((value[int(index[:-1])] if index else value) == 0.0)


def _meanings(blocks: Mapping[str, Block], name: str, port: str) -> tuple[Meaning, ...]:
    return type(blocks[name]).output_functions[port].meanings


def _listed(names: Sequence[str]) -> str:
    return f"{', '.join(names)} {'is' if len(names) == 1 else 'are'}"
