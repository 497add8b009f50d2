"""Continuous state space of any order and size: x' = A x + B u, y = C x + D u, for inputs that are held over a tick.

The step is exact: x[n+1] = e^(A T) x[n] + the integral of e^(A t) B u[n] over a tick, by the
exponential of the balanced matrix [[A, B], [0, 0]] T (Van Loan, IEEE Trans. Automatic Control 23,
1978).
"""

from proofmass.blocks.arithmetic.modes import balanced_exponential
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.blocks.filters.discrete_matrix_state_space import output, requires, strictly_proper_part, update


class HeldStateSpace(Block):
    """Linear analog system from a vector to a vector, sampled: a plant of many states, a model of an identification."""

    order: int = param("1", "Number of states, n.", default=2, at_least=1, at_most=64)
    input_size: int = param("1", "Number of inputs, m.", default=1, at_least=1, at_most=32)
    output_size: int = param("1", "Number of outputs, r.", default=1, at_least=1, at_most=32)
    transition: tuple[float, ...] = param("1/s", "A, n by n, row after row.", default=(0.0, 1e3, -1e3, -1e3))
    entry: tuple[float, ...] = param("1/s", "B, n by m, row after row.", default=(0.0, 1e3))
    readout: tuple[float, ...] = param("1", "C, r by n, row after row.", default=(1.0, 0.0))
    direct: tuple[float, ...] = param("1", "D, r by m, row after row.", default=(0.0,))

    input = Input("1", "What drives it, held over a tick.", shape=("input_size",))

    matrix = Buffer("From states to states, over a tick.", float, ("transition",))
    into = Buffer("From inputs to states, over a tick.", float, ("entry",))
    out_of = Buffer("C.", float, ("readout",))
    through = Buffer("D.", float, ("direct",))
    states = Buffer("x, zero in tick 0.", float, ("order",))
    following = Buffer("x of the next tick, while it is computed.", float, ("order",))


HeldStateSpace.requires(requires)


@HeldStateSpace.start
def start(
    p: HeldStateSpace,
    matrix: list[float],
    into: list[float],
    out_of: list[float],
    through: list[float],
    period: float,
) -> None:
    n, m = p.order, p.input_size
    a = [[v * period for v in p.transition[i * n : (i + 1) * n]] for i in range(n)]
    b = [[v * period for v in p.entry[i * m : (i + 1) * m]] for i in range(n)]
    joined = [left + right for left, right in zip(a, b, strict=True)] + [[0.0] * (n + m) for _ in range(m)]
    step = balanced_exponential(joined)[:n]
    matrix[:], into[:] = [v for row in step for v in row[:n]], [v for row in step for v in row[n:]]
    out_of[:], through[:] = p.readout, p.direct


for function in (output, strictly_proper_part):
    HeldStateSpace.output("1", shape=("output_size",), dtype=float)(function)
HeldStateSpace.update(update)
