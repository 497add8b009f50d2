"""The steady state of a linear map with a constant input: scale factor and bias, and their
derivatives by parameters.

x = A x + B u + step has one solution where no pole lies at 1. Modes that do not decay are projected
out first if input and constants do not reach them or the output does not show them (`lasting`): an
integrator after a difference, the phase of an oscillation.

An operating point has derivatives by the parameters too: a graph stands elsewhere with another
spring. Near the start they come from a run from tick 0 in dual numbers. An operating point x that
comes back after a period has
those of the implicit function: x = F(x, p) gives dx/dp = (I - A)^-1 dF/dp.
"""

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem, problem_of_output
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Rings
from proofmass.runner.analysis.linearisation.seeds import PointSlopes
from proofmass.runner.derivatives.dual import PARAMETERS, slopes_of
from proofmass.runner.derivatives.dual_plan import differentiated
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError

_ROUNDING = 1e-12
MOST_TICKS = 20_000  # ticks of blocks that are run in dual numbers, at most
_AT_REST = 1e-6  # part of its size by which a state at rest may move in a period


class SteadyState:
    """Scale factor and bias between outputs; raises `ModelError` without a steady state."""

    def __init__(self, planned: Plan, period_map: PeriodMap, target: Endpoint) -> None:
        self._map = period_map.kept(period_map.moving())
        self._rows = sum(entry[:2] == target for entry in period_map.outputs)
        a, b, c, _, step, _, at_input = self._parts(self._map.matrix)
        lasting = Lasting(a)
        if lasting.passes(np.column_stack([b, step - b * at_input]), c):
            raise planned.graph.placed(self._does_not_settle(target, lasting)).error
        rest = lasting.others
        self._inverse = rest @ np.linalg.inv(np.eye(len(a)) - rest @ a)
        self._by_input = self._inverse @ b
        self._at_zero = self._inverse @ (step - b * at_input)

    def values(self) -> tuple[float, float]:
        """Return scale factor and bias."""
        _, _, c, d, _, level, at_input = self._parts(self._map.matrix)
        return float(c @ self._by_input) + d, float(c @ self._at_zero) + level - d * at_input

    @property
    def rounding(self) -> float:
        """The part of a scale factor that rounding may make: of the sizes that it is the sum of."""
        _, _, c, d, *_ = self._parts(self._map.matrix)
        return _ROUNDING * (float(np.abs(c) @ np.abs(self._by_input)) + abs(d))

    @property
    def size(self) -> float:
        """The sum of the sizes whose difference is the bias: the output at the operating point and the input's part."""
        _, _, _, _, _, level, at_input = self._parts(self._map.matrix)
        return abs(level) + abs(self.values()[0] * at_input)

    def slopes(self, parameter: str) -> tuple[float, float]:
        """Return the derivatives of scale factor and bias by a parameter."""
        _, b, c, d, _, _, at_input = self._parts(self._map.matrix)
        da, db, dc, dd, dstep, dlevel, dinput = self._parts(self._map.slopes[parameter])
        by_input = self._inverse @ (da @ self._by_input + db)
        at_zero = self._inverse @ (da @ self._at_zero + dstep - db * at_input - b * dinput)
        scale = dc @ self._by_input + c @ by_input + dd
        bias = dc @ self._at_zero + c @ at_zero + dlevel - dd * at_input - d * dinput
        return float(scale), float(bias)

    def sizes(self, parameter: str) -> tuple[float, float]:
        """Return the sums of sizes that these derivatives are, of which rounding leaves a part."""
        _, b, c, d, _, _, at_input = (np.abs(part) for part in self._parts(self._map.matrix))
        by_parameter = self._parts(self._map.slopes[parameter])
        da, db, dc, dd, dstep, dlevel, dinput = (np.abs(part) for part in by_parameter)
        inverse, input_, zero = np.abs(self._inverse), np.abs(self._by_input), np.abs(self._at_zero)
        scale = dc @ input_ + c @ (inverse @ (da @ input_ + db)) + dd
        moved = inverse @ (da @ zero + dstep + db * at_input + b * dinput)
        return float(scale), float(dc @ zero + c @ moved + dlevel + dd * at_input + d * dinput)

    def _parts(self, matrix: Array) -> tuple[Array, Array, Array, float, Array, float, float]:
        """A, B for all values of the input alike, C, D, step and level of the mean output, and the input itself."""
        n, rows = self._map.order, self._rows
        mean = matrix[n : n + rows].mean(axis=0)
        whole = matrix[:n, n:-1].sum(axis=1)
        at_input = float(matrix[n + rows :, -1].mean())
        return matrix[:n, :n], whole, mean[:n], float(mean[n:-1].sum()), matrix[:n, -1], float(mean[-1]), at_input

    def _does_not_settle(self, target: Endpoint, lasting: Lasting) -> Problem:
        holders = lasting.holders([entry[0] for entry in self._map.states])
        return problem_of_output(
            target,
            message=f"{'.'.join(target)} does not settle: it has no scale factor and no bias",
            got=f"a mode that does not decay, of size {lasting.largest:.6g}, in {', '.join(holders)}",
            hint="a loop is unstable or open, or an integrator is fed by something constant",
        )


def slopes_near_start(plan: Plan, blocks: set[str], tick: int, rings: Rings) -> PointSlopes | None:
    """Return the derivatives of what blocks hold in a tick, by a run from tick 0; None where that takes too long."""
    if tick * len(blocks) > MOST_TICKS:
        return None
    moved = differentiated(plan)
    try:
        engine = DualTicks(moved, start(moved), blocks, (), (), False, True)
        engine.advance(tick, ())
    except (TickError, ModelError):  # the bits of a number depend on parameters
        return None
    numbers = dict(rings.states_of(engine.memory(), blocks))
    moved_by = {entry: slopes_of(value, PARAMETERS) for entry, value in numbers.items()}
    return {entry: {str(name): float(slope) for name, slope in own.items()} for entry, own in moved_by.items()}


def slopes_at_rest(everything: PeriodMap) -> PointSlopes | None:
    """Return the derivatives of a point that comes back, from the map of all that moves; None of
    one that does not.

    What every period leaves as it is, such as the entries of a table, has those of the start, and
    is left out.
    """
    n = everything.order
    a, step = everything.parts()[0], everything.matrix[:n, -1]
    if np.any(np.abs(step) > _AT_REST * np.maximum(np.abs(np.array(everything.point)), 1e-300) + 1e-300):
        return None
    rest = Lasting(a).others
    inverse = rest @ np.linalg.inv(np.eye(n) - rest @ a)
    columns = {name: inverse @ slope[:n, -1] for name, slope in everything.slopes.items()}
    return {
        everything.states[i]: {name: float(column[i]) for name, column in columns.items() if column[i]}
        for i in everything.moving()
    }
