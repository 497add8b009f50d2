"""Groups of continuous blocks moved by a tick in dual numbers: linearised where they are, then held exactly.

    x' = f + A (x - x0) + B (u - u0):   x(T) = x0 + exp(A T) (x - x0) + integral of exp(A t) (f + B (u - u0)) dt

f, with its slopes by what drives parameters, A and B are the group's own derivatives at the
operating point x0, u0, whichever method a run integrates it by. For a linear group this is its
exact step; another one moves as it does close to the point where it stands still, or,
`IntegratedAdvance`, as a run moves it, and a change of it by Magnus' integrator of fourth order
without commutators, exp(far A1 + near A2) exp(near A1 + far A2) with A of two instants in the tick
(Blanes and Moan, Applied Numerical Mathematics 56, 2006, 1519). Inputs are held, first-order holds
too; nothing of an event happens.

What moves A itself, a driven parameter or a factor that is held, acts on x as it is within the
tick:

    z' = A z + dA (x - x0),   z(0) = 0:   x(T) changes by z(T) beside what the slopes of f do

which is left out where the group has loops that Newton's method solves. A linear group that nothing
of this concerns is moved by the matrices of the run itself, `HeldAdvance`.

Algebraic loops are solved by Newton's method, with exact derivatives of the solution:

    u = g(u, p):   u <- u + (I - J)^-1 (g(u, p) - u),   J = dg/du at the solution

The implicit function theorem, as a chord iteration in dual numbers: from plain values each step
makes one more order of the derivatives by p exact (Griewank and Walther 2008, section 15.3).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from proofmass.blocks.arithmetic.modes import Matrix
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.continuous.algebraic import NoSolutionError, solve_in_place
from proofmass.runner.continuous.linear_equations import factorise, substitute
from proofmass.runner.derivatives.ball import Ball
from proofmass.runner.derivatives.dual import NO_SLOPE, SIGNALS, Dual, dual, plain, slopes_of, value_of
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.derivatives.dual_plan import dual_constants, dual_hold, dual_parameters, is_finite, typed
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.planned import Filled, Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.plan.stages import StageContext, Stages
from proofmass.runner.reference.advance import Advance, Moment, PlainAdvance

STATES = SIGNALS + 1  # level of the slopes by the states of a group, with slopes by signals
_ORDERS = 2  # signals, and parameters of their slopes
_NODES = (0.5 - math.sqrt(3.0) / 6.0, 0.5 + math.sqrt(3.0) / 6.0)  # in a tick (Gauss, Legendre)
_NEAR, _FAR = 0.25 + math.sqrt(3.0) / 6.0, 0.25 - math.sqrt(3.0) / 6.0
_ALIKE = 1e-15  # relative difference of two changes that are the same but for a factor
_KEPT = 64  # pairs of matrices


def solve_dual(tears: Sequence[Any], others: Sequence[Any], signals: Any, value: Callable[[Any], Any]) -> bool:
    """Solve a loop as `algebraic.solve_in_place` does; `value(node)` and the solution may be dual numbers."""
    for tear in tears:
        signals[tear] = plain(signals[tear])
    if not solve_in_place(tears, others, signals, lambda node: plain(value(node))):
        return False

    def equations(unknown: list[Any]) -> list[Any]:
        for tear, held in zip(tears, unknown, strict=True):
            signals[tear] = held
        for node in others:
            signals[node] = value(node)
        return [value(tear) for tear in tears]

    solution: list[Any] = [signals[tear] for tear in tears]
    directions = [("tear", number) for number in range(len(tears))]
    moved = equations([dual(v, {key: 1.0}, SIGNALS) for v, key in zip(solution, directions, strict=True)])
    jacobian = [[plain(slopes_of(v, SIGNALS).get(key, 0.0)) for key in directions] for v in moved]
    inverse = _inverse([[float(i == j) - v for j, v in enumerate(row)] for i, row in enumerate(jacobian)])
    if inverse is None:
        return False
    for _ in range(_ORDERS):
        apart = [there - here for there, here in zip(equations(solution), solution, strict=True)]
        solution = [
            sum((factor * d for factor, d in zip(row, apart, strict=True)), here)
            for row, here in zip(inverse, solution, strict=True)
        ]
    equations(solution)
    return True


def _inverse(rows: list[list[float]]) -> list[list[float]] | None:
    """The inverse of a matrix, None where there is none."""
    n = len(rows)
    matrix, order = [v for row in rows for v in row], [0.0] * n
    if not factorise(matrix, n, order):
        return None
    columns = [[float(i == j) for i in range(n)] for j in range(n)]
    for column in columns:
        substitute(matrix, n, order, column)
    return [list(row) for row in zip(*columns, strict=True)]


class DualStages(Stages):
    """The functions of a group, on dual numbers."""

    _solve_loop = staticmethod(solve_dual)

    def __init__(self, plan: Filled, group: Group, by_parameters: bool) -> None:
        self._plan, self._by_parameters = plan, by_parameters
        super().__init__(plan.blocks, plan.schedule, group, plan.block_period)

    def states(self, x: Any) -> dict[str, Any]:
        """The states of all blocks; dual numbers stay what they are."""
        states, place = {}, 0
        for name, state, kinds in self._states:
            values = zip(kinds, x[place : place + len(kinds)], strict=True)
            states[name] = state(*(typed(kind, v) for kind, v in values))
            place += len(kinds)
        return states

    def _constants_of(self, name: str, moved: Mapping[str, Any]) -> Any:
        given = dual_parameters(self._plan, name, self._by_parameters)
        vars(given).update(moved)
        return dual_constants(self.blocks[name], given, self.periods(name))

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        return for_duals(behaviour.function)


class DualAdvance(Advance):
    """Moves the states of one group by a tick in dual numbers."""

    def __init__(self, plan: Filled, group: Group, by_parameters: bool, linear: bool = False) -> None:
        self.stages, self.period, self._is_linear = DualStages(plan, group, by_parameters), plan.period, linear
        self._held: dict[str, tuple[Matrix, Matrix]] = {}  # by A and B: matrices come again

    def __call__(self, moment: Moment) -> dict[str, Any]:
        """Return the states of the group's blocks one tick later."""
        return self.moved(moment)

    def through(self, moment: Moment, nodes: Sequence[Sequence[float]]) -> list[Any]:
        """Return the slopes of the states one tick later, of a step that goes through two states in the tick."""
        group = self.stages.group
        now = [getattr(moment.states[block], field) for block, field in group.states]
        now += [moment.wires[node] for node in group.inputs]
        n = len(group.states)
        apart = [value - value_of(value, SIGNALS) for value in now]
        own, inputs = apart[:n], apart[n:]
        held = [value_of(value, SIGNALS) for value in now[n:]]
        parts = [
            self._linear(moment._replace(time=moment.time + part * self.period), [*node, *held])
            for part, node in zip(_NODES, nodes, strict=True)
        ]
        for weights in ((_NEAR, _FAR), (_FAR, _NEAR)):
            near, far = weights
            a, b = (
                [
                    [near * v + far * w for v, w in zip(*rows, strict=True)]
                    for rows in zip(parts[0][i], parts[1][i], strict=True)
                ]
                for i in (0, 1)
            )
            rates = [near * v + far * w for v, w in zip(parts[0][2], parts[1][2], strict=True)]
            transition, entry = self._hold(a, _forced(b))
            moving = [*own, *inputs, *(_without(rate, len(now)) for rate in rates)]
            own = [
                sum((factor * v for factor, v in zip((*left, *right), moving, strict=True)), 0.0)
                for left, right in zip(transition, entry, strict=True)
            ]
        return own

    def moved(self, moment: Moment) -> dict[str, Any]:
        """Return the states of the group's blocks one tick later."""
        constants, states, wires, _, time = moment
        group = self.stages.group
        now = [getattr(states[block], field) for block, field in group.states]
        now += [wires[node] for node in group.inputs]
        held_values = [value_of(value, SIGNALS) for value in now]
        a, b, rates = self._linear(moment, held_values)
        transition, entry = self._hold(a, _forced(b))
        turned = {} if group.guesses else self._turned(constants, now, rates, a, time)
        apart = [_slopes_alone(value) for value in now]  # a ball less itself is no zero
        apart += [_without(rate, len(now)) for rate in rates]
        begin = held_values[: len(a)]
        if self._is_linear:  # about zero: x0 + P (A x0) of balls is wider than exp(A T) x0, and more so in each tick
            still = self._rates(constants, [0.0] * len(now), len(a), [], time)
            full = [*held_values, *(value_of(rate, SIGNALS) for rate in still)]
            begin = [
                sum((factor * v for factor, v in zip((*left, *right), full, strict=True)), 0.0)
                for left, right in zip(transition, entry, strict=True)
            ]
            apart[len(now) :] = map(_slopes_alone, apart[len(now) :])
        moved = [
            sum((factor * v for factor, v in zip((*left, *right), apart, strict=True)), point)
            for left, right, point in zip(transition, entry, begin, strict=True)
        ]
        moved = [value + dual(0.0, {k: z[i] for k, z in turned.items()}, SIGNALS) for i, value in enumerate(moved)]
        fields = zip(group.kinds, now, moved, strict=False)
        kept = [after if kind is float else before for kind, before, after in fields]
        return self.stages.states(kept)

    def _linear(self, moment: Moment, about: Sequence[Any]) -> tuple[list[list[Any]], list[list[Any]], list[Any]]:
        """Return A, B and the rates about some states and inputs."""
        group = self.stages.group
        n = len(group.states)
        seeded = [value + dual(0.0, {j: 1.0}, SIGNALS) for j, value in enumerate(about)]
        guesses = [plain(moment.wires[node]) for node in group.guesses]
        rates = self._rates(moment.constants, seeded, n, guesses, moment.time)
        a = [[slopes_of(rate, SIGNALS).get(j, 0.0) for j in range(n)] for rate in rates]
        b = [[slopes_of(rate, SIGNALS).get(j, 0.0) for j in range(n, len(about))] for rate in rates]
        for (block, _), slopes in zip(group.states, zip(a, b, strict=True), strict=True):
            if not all(is_finite(plain(slope)) for part in slopes for slope in part):
                self.stages.at = f"{block}.derivative"
                raise ArithmeticError(NO_SLOPE)
        return a, b, rates

    def rates(self, moment: Moment, states: Sequence[float]) -> list[float]:
        """Return the derivatives of some states, in plain numbers."""
        group = self.stages.group
        point = [*states, *(plain(moment.wires[node]) for node in group.inputs)]
        guesses = [plain(moment.wires[node]) for node in group.guesses]
        return [float(plain(rate)) for rate in self._rates(moment.constants, point, len(states), guesses, moment.time)]

    def _turned(
        self, constants: Mapping[str, Any], now: list[Any], rates: list[Any], a: list[list[Any]], time: float
    ) -> dict[Any, list[Any]]:
        """Return z(T) by the direction of what moves A."""
        n = len(a)
        seeded = [value_of(value, SIGNALS) + dual(0.0, {j: 1.0}, STATES) for j, value in enumerate(now[:n])]
        again = self._rates(constants, [*seeded, *now[n:]], n, [], time)
        entries = [(i, j, slope) for i, rate in enumerate(again) for j, slope in slopes_of(rate, STATES).items()]
        directions = dict.fromkeys(key for _, _, slope in entries for key in slopes_of(slope, SIGNALS))
        starts = [value_of(rate, SIGNALS) for rate in rates]
        ends, basis = dict[Any, list[Any]](), list[tuple[Matrix, list[Any]]]()
        for key in directions:
            change: Matrix = [[0.0] * n for _ in range(n)]
            for i, j, slope in entries:
                change[i][j] = slopes_of(slope, SIGNALS).get(key, 0.0)
            factor, z = _multiple(change, basis)
            if z is None:
                z = self._driven(a, change, starts)
                basis.append((change, z))
            ends[key] = [factor * value for value in z]
        return ends

    def _driven(self, a: list[list[Any]], change: Matrix, starts: list[Any]) -> list[Any]:
        """Return z(T), of x and z as one system the rates of x at the start of the tick force."""
        n = len(a)
        both = [[*row, *[0.0] * n] for row in a]
        both += [[*left, *right] for left, right in zip(change, a, strict=True)]
        rows = self._hold(both, [[float(i == j) for j in range(n)] for i in range(2 * n)])[1][n:]
        return [sum(factor * value for factor, value in zip(row, starts, strict=True)) for row in rows]

    def _hold(self, a: list[list[Any]], forced: list[list[Any]]) -> tuple[Matrix, Matrix]:
        wanted = repr((a, forced))
        if wanted not in self._held:
            if len(self._held) >= _KEPT:
                self._held.clear()
            self._held[wanted] = dual_hold(a, forced, self.period)
        return self._held[wanted]

    def _rates(
        self, constants: Mapping[str, Any], point: list[Any], n: int, guesses: list[float], time: float
    ) -> list[Any]:
        """Derivatives of the states at a point, what drives the constants as it is on the wires."""
        out: list[Any] = [0.0] * n
        still = [0.0] * len(self.stages.group.ramps)
        self.stages.rates(StageContext(constants, point[n:], still, guesses, time), time, point[:n], out)
        if self.stages.unsolved:
            raise NoSolutionError(self.stages.unsolved)
        return out


def _multiple(change: Matrix, basis: Sequence[tuple[Matrix, list[Any]]]) -> tuple[float, list[Any] | None]:
    """Return what z is a multiple of, for a change of A that is one of another: many directions move one parameter."""
    rows = [[plain(value) for value in row] for row in change]
    exact = not any(isinstance(value, Dual | Ball) for row in change for value in row)
    for other, z in basis if exact else ():
        pairs = [
            (u, plain(v)) for left, right in zip(rows, other, strict=True) for u, v in zip(left, right, strict=True)
        ]
        largest, of = max(((abs(v), u / v) for u, v in pairs if v), default=(0.0, 0.0))
        if largest and all(abs(u - of * v) <= _ALIKE * abs(of) * largest for u, v in pairs):
            return of, z
    return 1.0, None


class HeldAdvance(Advance):
    """Moves the states of a linear group by a tick as a run does, by matrices that never change."""

    def __init__(self, plan: Plan, solver: Solver) -> None:
        self.stages = DualStages(plan, solver.group, False)
        self._run = PlainAdvance(plan, solver, ())
        self._rows: list[list[tuple[int, float]]] = []  # of each state, what it follows from

    def __call__(self, moment: Moment) -> dict[str, Any]:
        """Return the states of the group's blocks one tick later."""
        group = self.stages.group
        if not self._rows:
            transition, entry = self._run.matrices(moment.constants, {})
            rows = ((*own, *more) for own, more in zip(transition, entry, strict=True))
            self._rows = [[(j, factor) for j, factor in enumerate(row) if factor] for row in rows]
        values = [getattr(moment.states[block], field) for block, field in group.states]
        values += [*(moment.wires[node] for node in group.inputs), 1.0]
        return self.stages.states([sum((factor * values[j] for j, factor in row), 0.0) for row in self._rows])


class IntegratedAdvance(Advance):
    """Moves states of one group by a tick as a run does, with the slopes of its linearisation."""

    def __init__(self, plan: Plan, solver: Solver, by_parameters: bool) -> None:
        self._linear = DualAdvance(plan, solver.group, by_parameters)
        self._run = PlainAdvance(plan, solver, [0.0] * len(solver.group.states))
        self.stages = self._linear.stages

    def __call__(self, moment: Moment) -> dict[str, Any]:
        """Return the states of the group's blocks one tick later."""
        group, states = self.stages.group, {name: _plain_tuple(state) for name, state in moment.states.items()}
        constants = {name: _plain_tuple(value) for name, value in moment.constants.items()}
        wires = {node: plain(value) for node, value in moment.wires.items()}
        after = self._run(Moment(constants, states, wires, {}, moment.time))
        last = moment.time + self._linear.period
        first, second = ([float(getattr(part[b], field)) for b, field in group.states] for part in (states, after))
        before, behind = self._linear.rates(moment, first), self._linear.rates(moment._replace(time=last), second)
        nodes = [_between(first, second, before, behind, self._linear.period, part) for part in _NODES]
        slopes = dict(zip(group.states, self._linear.through(moment, nodes), strict=True))
        return {
            name: type(state)(
                *(
                    value + dual(0.0, slopes_of(slopes[name, field], SIGNALS), SIGNALS) if kind is float else value
                    for (field, kind), value in zip(type(state).__annotations__.items(), state, strict=True)
                )
            )
            for name, state in after.items()
        }


def _between(
    first: Sequence[float],
    last: Sequence[float],
    before: Sequence[float],
    behind: Sequence[float],
    period: float,
    part: float,
) -> list[float]:
    """States within a tick, by Hermite's cubic between its ends."""
    rest = 1.0 - part
    return [
        (1.0 + 2.0 * part) * rest * rest * x + part * part * (3.0 - 2.0 * part) * y
        + part * rest * period * (rest * u - part * v)
        for x, y, u, v in zip(first, last, before, behind, strict=True)
    ]  # fmt: skip


def _forced(b: list[list[Any]]) -> list[list[Any]]:
    """Return the effect of inputs and of rates of their own."""
    return [[*row, *(float(i == j) for j in range(len(b)))] for i, row in enumerate(b)]


def _plain_tuple(values: Any) -> Any:
    """A NamedTuple of plain numbers."""
    return values if values is None else type(values)(*map(plain, values))


def _slopes_alone(value: Any) -> Any:
    """The slopes of a number by signals, on zero."""
    return dual(0.0, slopes_of(value, SIGNALS), SIGNALS)


def _without(rate: Any, own: int) -> Any:
    """A rate with the slopes by what drives its constants alone: those by states and inputs are in A and B."""
    slopes = {key: slope for key, slope in slopes_of(rate, SIGNALS).items() if key not in range(own)}
    return dual(value_of(rate, SIGNALS), slopes, SIGNALS)
