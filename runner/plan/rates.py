"""The rates of a continuous group at a point, and the matrices that move linear ones by a tick."""

from collections.abc import Mapping, Sequence
from typing import Any

from proofmass.blocks.arithmetic.modes import Matrix
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.continuous.exact_hold import UNIT, hold
from proofmass.runner.plan.stages import StageContext, Stages


def assemble(
    stages: Stages,
    constants: Mapping[str, Any],
    period: float,
    factors: Mapping[Endpoint, float] | None = None,
    affine: bool = False,
) -> tuple[Matrix, Matrix]:
    """Transition and entry of a linear group; its rates for unit states and inputs are the columns of A and B.

    `factors` are inputs that multiply others, with their values. The column of the first factor is
    their effect at zero states and inputs, for an input of one; the columns of the other factors
    are zero. An `affine` group has a column more, of its rates there.
    """
    group, factors_at = stages.group, factors or {}
    n, m = len(group.states), len(group.inputs)
    rest = [0.0] * n + [factors_at.get(node, 0.0) for node in group.inputs]
    places = [n + group.inputs.index(node) for node in factors_at]
    offset = rates_at(stages, constants, rest) if factors_at or affine else [0.0] * n
    unit = UNIT if affine else 1.0
    columns = [
        ([0.0] * n if j in places[1:] else offset)
        if j in places
        else [
            (rate - c) / unit
            for rate, c in zip(
                rates_at(stages, constants, [unit if i == j else v for i, v in enumerate(rest)]), offset, strict=True
            )
        ]
        for j in range(n + m)
    ]
    columns += [offset] if affine else []
    rows = [list(row) for row in zip(*columns, strict=True)]
    ramps = tuple(group.inputs.index(node) for node in group.ramps)
    return hold([row[:n] for row in rows], [row[n:] for row in rows], period, ramps)


def rates_at(
    stages: Stages, constants: Mapping[str, Any], point: Sequence[float], wires: Mapping[Endpoint, float] | None = None
) -> list[float]:
    """Derivatives for a list of states and then held inputs; loops are solved from the wires, or from zero."""
    n = len(stages.group.states)
    out = [0.0] * n
    guesses = [wires[node] if wires else 0.0 for node in stages.group.guesses]
    context = StageContext(constants, point[n:], [0.0] * len(stages.group.ramps), guesses, 0.0)
    stages.rates(context, 0.0, point[:n], out)
    return out
