"""A plan whose constants and start values are dual numbers in all parameters of its blocks, and the hold of such.

The derivative of a matrix exponential is read off a larger one, which makes it as exact as the
exponential itself: exp [[M, dM], [0, M]] = [[exp M, d exp M], [0, exp M]] (Van Loan, IEEE Trans.
Automatic Control 23, 1978, 395). Where the numbers have one level, the blocks of that matrix are
computed apart, for all directions at once.
"""

import math
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from proofmass.blocks.arithmetic.modes import Matrix
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.continuous.exact_hold import TERMS, balance, hold
from proofmass.runner.derivatives.ball import Ball, ball_exponential
from proofmass.runner.derivatives.dual import PARAMETERS, Dual, dual, plain, slopes_of, value_of
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.derivatives.homogeneous import Homogeneous, homogeneous_exponential
from proofmass.runner.derivatives.polynomial import PolynomialBall, polynomial_exponential
from proofmass.runner.plan.constants import constants_of
from proofmass.runner.plan.keys import VectorOf
from proofmass.runner.plan.planned import Filled, Plan

_EXPONENTIALS: Mapping[type, Callable[[list[list[Any]], float], Matrix]] = {  # the first of these that is in a matrix
    Homogeneous: homogeneous_exponential,
    PolynomialBall: polynomial_exponential,
    Ball: ball_exponential,
}


def differentiated(plan: Plan) -> Plan:
    """The plan in dual numbers, a direction for each parameter, `"block.parameter"` or `"block.parameter[2]"`."""
    parameters = {name: dual_parameters(plan, name, True) for name in plan.blocks}
    constants, starts, buffers = dict(plan.constants), dict(plan.starts), dict(plan.buffers)
    for name, block in plan.blocks.items():
        if name in plan.digital:
            continue  # its coefficients are rounded to registers: they have no derivative
        try:
            if not plan.is_driven(name):
                constants[name] = dual_constants(block, parameters[name], plan.block_period(name))
            if "start" in type(block).functions:
                starts[name], filled = dual_start(plan, name, parameters[name])
                buffers |= filled
        except (ArithmeticError, ValueError, TypeError, AttributeError) as error:
            raise plan.graph.placed(_no_derivative(name, error)).error from error
    return replace(plan, constants=constants, starts=starts, buffers=buffers)


def dual_start(plan: Filled, name: str, parameters: Any) -> tuple[Any, dict[VectorOf, tuple[Any, ...]]]:
    """Return the state of a block at the start of a run and what it writes into its buffers, of such parameters."""
    block = plan.blocks[name]
    filled = {buffer: list(plan.buffers[name, buffer]) for buffer in type(block).buffers}
    start = type(block).functions["start"]
    state = for_duals(start.function)(parameters, *start.named({**filled, "period": plan.block_period(name)}))
    return _typed(state), {(name, buffer): tuple(values) for buffer, values in filled.items()}


def dual_parameters(plan: Filled, name: str, by_parameters: bool) -> Any:
    """The parameters of a block by name, each real one with a direction of its own if wanted."""
    block, read = plan.blocks[name], types.SimpleNamespace()
    for parameter, declared in type(block).parameters.items():
        value, key = getattr(block, parameter), f"{name}.{parameter}"
        if not by_parameters or (name, parameter) in plan.schedule.drivers:
            pass
        elif declared.kind is float:
            value = dual(value, {key: 1.0}, PARAMETERS)
        elif declared.kind is tuple:
            value = tuple(dual(entry, {f"{key}[{i}]": 1.0}, PARAMETERS) for i, entry in enumerate(value))
        setattr(read, parameter, value)
    return read


def dual_constants(block: Block, parameters: Any, period: float) -> Any:
    """Return constants of parameters that may be dual numbers; integers among the constants are plain counts."""
    if "constants" in type(block).functions:
        behaviour = type(block).functions["constants"]
        constants = _typed(for_duals(behaviour.function)(parameters, *behaviour.named({"period": period})))
    else:
        kind = type(block).parameters_class()
        constants = _typed(kind(*(getattr(parameters, name) for name in kind._fields)))  # type: ignore[attr-defined]
    counts = [
        name
        for name, kind in type(constants).__annotations__.items()
        if kind is int and isinstance(getattr(constants, name), Dual)
    ]
    if counts:
        read = {name: getattr(parameters, name) for name in type(block).parameters}
        known = {n: tuple(map(plain, v)) if isinstance(v, tuple) else plain(v) for n, v in read.items()}
        counted = constants_of(block, types.SimpleNamespace(**known), period)
        constants = constants._replace(**{name: getattr(counted, name) for name in counts})
    return constants


def _typed(values: Any) -> Any:
    """A NamedTuple with each field of its declared type; dual numbers stay what they are."""
    if values is None:
        return None
    kinds = type(values).__annotations__.values()
    return type(values)(*(typed(k, v) for k, v in zip(kinds, values, strict=True)))


def is_finite(value: Any) -> bool:
    """Return whether a number without slopes is finite, as balls always are."""
    return isinstance(value, Ball) or math.isfinite(value)


def typed(kind: Callable[[Any], Any], value: Any) -> Any:
    """Return a value of a type; dual numbers, and balls of real numbers, stay what they are."""
    if isinstance(value, Dual) or (kind is float and isinstance(value, Ball)):
        return value
    return kind(value)


def dual_hold(a: Sequence[Sequence[Any]], b: Sequence[Sequence[Any]], period: float) -> tuple[Matrix, Matrix]:
    """Return the matrices of `exact_hold.hold` for duals of any levels, or balls."""
    size = len(a)
    rows = _held([[*left, *right] for left, right in zip(a, b, strict=True)], size, period)
    return [row[:size] for row in rows], [row[size:] for row in rows]


def _held(rows: list[list[Any]], size: int, period: float) -> Matrix:
    """Return the first rows of exp([[A, B], [0, 0]] period), where `rows` are [A B] and A has `size` columns."""
    levels = [number.level for row in rows for number in row if isinstance(number, Dual)]
    if not levels:
        kinds = {type(number) for row in rows for number in row}
        for kind, exponential in _EXPONENTIALS.items():
            if kind in kinds:
                return exponential(rows, period)[:size]
        transition, entry = hold([row[:size] for row in rows], [row[size:] for row in rows], period)
        return [[*left, *right] for left, right in zip(transition, entry, strict=True)]
    level, width = max(levels), len(rows[0])
    below = [[0.0] * width for _ in range(width - size)]
    values = [[value_of(number, level) for number in row] for row in rows]
    keys = dict.fromkeys(key for row in rows for number in row for key in slopes_of(number, level))
    slopes = {key: [[slopes_of(number, level).get(key, 0.0) for number in row] for row in rows] for key in keys}
    if all(isinstance(number, int | float) for of in (values, *slopes.values()) for row in of for number in row):
        moved = _term_by_term(values + below, [slope + below for slope in slopes.values()], period)
    else:
        moved = [_in_larger(values + below, slope + below, width, period) for slope in slopes.values()]
    return [
        [
            dual(value, {key: of[i][j] for key, of in zip(keys, moved, strict=True)}, level)
            for j, value in enumerate(row)
        ]
        for i, row in enumerate(_held(values, size, period))
    ]


def _term_by_term(values: Matrix, slopes: Sequence[Matrix], period: float) -> list[Matrix]:
    """Return derivatives of exp(M period): those of the series of `matrix_exponential`, in all directions at once."""
    # start-up time: runs need no derivatives
    import numpy as np

    size = len(values)
    flat, scale = [period * entry for row in values for entry in row], [1.0] * size
    balance(flat, size, scale)
    matrix, units = np.array(flat).reshape(size, size), np.array(scale)
    halvings = max(0, math.frexp(np.abs(matrix).sum(axis=1).max())[1])
    matrix = matrix * 0.5**halvings
    by = np.reshape(slopes, (-1, size, size)) * (period * 0.5**halvings) * units / units[:, np.newaxis]
    grown, moved = matrix, by
    with np.errstate(over="ignore", invalid="ignore"):
        for term in range(TERMS, 1, -1):
            moved = (by @ grown + matrix @ moved) / term + by
            grown = matrix @ grown / term + matrix
        for _ in range(halvings):
            moved = 2.0 * moved + moved @ grown + grown @ moved
            grown = 2.0 * grown + grown @ grown
    listed: list[Matrix] = (moved * units[:, np.newaxis] / units).tolist()
    return listed


def _in_larger(values: Matrix, slope: Matrix, width: int, period: float) -> Matrix:
    both = [[*left, *right] for left, right in zip(values, slope, strict=True)]
    both += [[*[0.0] * width, *row] for row in values]
    return [row[width:] for row in _held(both, 2 * width, period)[:width]]


def _no_derivative(name: str, error: Exception) -> Problem:
    return Problem(
        message="its constants have no derivative by its parameters",
        got=str(error),
        hint="margins without --sensitivity need none; else move the parameter off this value",
        path=("blocks", name),
    )
