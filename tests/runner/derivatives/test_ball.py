"""Balls hold what mpmath says of every number in them; whatever differs within them has no answer."""

import math
import random
import types
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from proofmass import blocks
from proofmass.blocks.arithmetic import elementary
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.derivatives.ball import Ball, UndecidedError, ball, ball_exponential, of_balls
from proofmass.runner.derivatives.dual import dual, plain, slopes_of
from proofmass.runner.derivatives.dual_functions import dual_math, for_duals
from proofmass.runner.derivatives.dual_plan import dual_constants
from proofmass.runner.plan.constants import constants_of

FUNCTIONS: list[tuple[Callable[..., Any], Callable[..., Any], float, float]] = [
    (math.exp, mpmath.exp, -20.0, 20.0),
    (elementary.exponential, mpmath.exp, -20.0, 20.0),
    (elementary.exponential_less_one, mpmath.expm1, -1e-3, 1e-3),
    (elementary.logarithm, mpmath.log, 1e-3, 1e3),
    (elementary.logarithm_of_one_plus, mpmath.log1p, -0.5, 1.0),
    (elementary.binary_logarithm, lambda x: mpmath.log(x, 2), 1e-3, 1e3),
    (math.log10, mpmath.log10, 1e-3, 1e3),
    (math.sqrt, mpmath.sqrt, 0.0, 1e6),
    (math.cbrt, mpmath.cbrt, 1e-6, 1e6),
    (elementary.sine, mpmath.sin, -10.0, 10.0),
    (elementary.cosine, mpmath.cos, -10.0, 10.0),
    (elementary.tangent, mpmath.tan, -1.5, 1.5),
    (elementary.arcsine, mpmath.asin, -1.0, 1.0),
    (elementary.arccosine, mpmath.acos, -1.0, 1.0),
    (elementary.arctangent, mpmath.atan, -50.0, 50.0),
    (elementary.hyperbolic_sine, mpmath.sinh, -5.0, 5.0),
    (elementary.hyperbolic_cosine, mpmath.cosh, -5.0, 5.0),
    (elementary.hyperbolic_tangent, mpmath.tanh, -5.0, 5.0),
    (math.erf, mpmath.erf, -3.0, 3.0),
    (elementary.sine_of_turns, lambda x: mpmath.sin(2 * mpmath.pi * x), -3.0, 3.0),
    (elementary.cosine_of_turns, lambda x: mpmath.cos(2 * mpmath.pi * x), -3.0, 3.0),
]


def inside(value: Any, of: Ball) -> bool:
    low, high = of.ends()
    return low <= value <= high


@pytest.mark.exhaustive(but=7)
@pytest.mark.parametrize(("ours", "exact", "low", "high"), FUNCTIONS, ids=lambda of: getattr(of, "__name__", ""))
def test_functions_hold_every_value_and_stay_close(ours: Any, exact: Any, low: float, high: float) -> None:
    draw = random.Random(1)
    for _ in range(100):
        middle = draw.uniform(low, high)
        width = 10.0 ** draw.uniform(-12.0, -2.0) * (high - low)
        ends = max(low, middle - width), min(high, middle + width)
        whole = of_balls(ours, ball(*ends))
        with mpmath.workprec(200):
            values = [exact(mpmath.mpf(draw.uniform(*ends))) for _ in range(20)]
            values += [exact(mpmath.mpf(end)) for end in ends]
        assert all(inside(value, whole) for value in values)
        assert all(inside(ours(draw.uniform(*ends)), whole) for _ in range(5))
        spread = float(max(values) - min(values))
        assert whole.ends()[1] - whole.ends()[0] <= 20.0 * spread + 1e-7 * (1.0 + abs(float(values[0])))


def test_functions_of_a_number_are_those_of_its_ball() -> None:
    for ours, _, low, high in FUNCTIONS:
        x = low + 0.7 * (high - low)
        assert [float(end) for end in of_balls(ours, ball(x, x)).ends()] == pytest.approx([ours(x)] * 2, rel=1e-12)


def test_arithmetic_holds_every_value() -> None:
    draw = random.Random(2)
    operations: list[Callable[[Any, Any], Any]] = [
        lambda a, b: a + b,
        lambda a, b: a - b,
        lambda a, b: a * b,
        lambda a, b: a / (b + 7.0),
        lambda a, b: (a**3 - 2.0 * b) / 7.0,
        lambda a, b: abs(a) - (-b),
    ]
    for _ in range(300):
        a, b = (sorted(draw.uniform(-5.0, 5.0) for _ in range(2)) for _ in range(2))
        x, y = draw.uniform(*a), draw.uniform(*b)
        for operation in operations:
            assert inside(operation(x, y), operation(ball(*a), ball(*b)))


def test_what_differs_within_a_ball_has_no_answer() -> None:
    x = ball(1.0, 2.0)
    assert x > 0.5
    assert x < 3.0
    assert x != 0.0
    assert x != 5.0
    assert ball(2.0, 2.0) == 2.0
    assert math.floor(ball(3.1, 3.9)) == 3
    assert round(ball(2.6, 3.4)) == 3
    questions: list[Callable[[], Any]] = [
        lambda: x > 1.5,
        lambda: x == 1.5,
        lambda: math.floor(ball(2.9, 3.1)),
        lambda: round(ball(2.4, 2.6)),
        lambda: round(ball(2.5, 2.5)),
        lambda: bool(ball(-1.0, 1.0)),
        lambda: 1.0 / ball(-1.0, 1.0),
        lambda: of_balls(math.log, ball(-1.0, 1.0)),
        lambda: of_balls(math.gamma, x),
        lambda: int(ball(0.5, 1.5)),
    ]
    for question in questions:
        with pytest.raises(UndecidedError):
            question()
    for silent in (float, math.exp, hash):
        with pytest.raises(TypeError):
            silent(x)


def test_a_block_that_compares_is_undecided_and_one_that_need_not_is_not() -> None:
    def limited(x: float) -> float:
        return x if x < 1.0 else math.exp(1.0 - x)

    assert inside(0.3, for_duals(limited)(ball(0.1, 0.5)))
    assert inside(math.exp(-1.5), for_duals(limited)(ball(2.0, 3.0)))
    with pytest.raises(UndecidedError):
        for_duals(limited)(ball(0.5, 1.5))


@pytest.mark.parametrize(
    "name", ["exp", "expm1", "log", "log1p", "atan", "sinh", "tanh", "asinh", "erf", "erfc", "sqrt"]
)
def test_a_function_that_rises_or_falls_has_the_range_of_its_ends(name: str) -> None:
    """Arb's own is wider: tanh of 1 to 9 may be 2."""
    ends = of_balls(getattr(math, name), ball(1.0, 9.0)).ends()
    exact = sorted(float(getattr(mpmath, name)(end)) for end in (1, 9))
    assert ends == pytest.approx(exact, rel=0.0, abs=4e-8 * max(map(abs, exact)))


def test_the_slope_of_a_saturation_has_a_bound_of_all_its_arguments() -> None:
    """1 - tanh^2, where 1 / cosh^2 of a wide ball has none."""
    saturates: Any = for_duals(elementary.hyperbolic_tangent)
    found = slopes_of(saturates(dual(ball(-1.0, 7.0), {0: 1.0})))[0].ends()
    assert -1.0 < found[0] <= 1.0 - math.tanh(7.0) ** 2
    assert 1.0 <= found[1] < 2.0


def test_slopes_of_balls_hold_the_slopes_of_all_numbers() -> None:
    def bent(x: Any) -> Any:
        return dual_math.sin(x * x) / (1.0 + dual_math.exp(-x))

    def exact(x: float) -> float:
        value = mpmath.diff(lambda t: mpmath.sin(t * t) / (1 + mpmath.exp(-t)), mpmath.mpf(x))
        return float(value)

    whole = bent(dual(ball(0.7, 0.8), {"x": 1.0}))
    for x in np.linspace(0.7, 0.8, 21):
        assert inside(exact(float(x)), slopes_of(whole)["x"])
        assert inside(math.sin(x * x) / (1.0 + math.exp(-x)), plain(whole))


@pytest.mark.exhaustive
def test_exponentials_of_matrices_hold_those_of_all_matrices() -> None:
    draw = np.random.default_rng(3)
    for _ in range(20):
        a = draw.normal(size=(2, 3))
        whole = ball_exponential([[ball(v - 1e-3, v + 1e-3) for v in row] for row in a], 0.7)
        for _ in range(5):
            matrix = np.zeros((3, 3))
            matrix[:2] = a + draw.uniform(-1e-3, 1e-3, size=a.shape)
            exact = mpmath.expm(mpmath.matrix((matrix * 0.7).tolist()))
            assert all(inside(exact[i, j], Ball(whole[i][j].arb)) for i in range(2) for j in range(3))


def _kinds() -> list[type[Block]]:
    every = (getattr(blocks, name) for name in dir(blocks))
    kinds = [kind for kind in every if isinstance(kind, type) and issubclass(kind, Block) and kind is not Block]
    return [kind for kind in kinds if "constants" in kind.functions and not kind.has_formats()]


@pytest.mark.exhaustive
def test_constants_of_every_block_hold_those_of_all_sensors() -> None:
    """Boxes of parameters about the default, wide and narrow; a block that decides differently in one is undecided."""
    draw, seen, silent = random.Random(5), set[str](), set[str]()
    for kind in _kinds():
        block = kind()
        free = [n for n, p in kind.parameters.items() if p.kind is float and getattr(block, n) != 0.0]
        given = {name: getattr(block, name) for name in kind.parameters}
        for part in (1e-9, 1e-6, 1e-3, 1e-2):
            ends = {n: sorted((getattr(block, n) * (1.0 - part), getattr(block, n) * (1.0 + part))) for n in free}
            try:
                boxes = types.SimpleNamespace(**given | {n: ball(*of) for n, of in ends.items()})
                whole = dual_constants(block, boxes, 1e-4)
            except (UndecidedError, TypeError):
                silent.add(kind.__name__)
                continue
            for _ in range(20):
                sensor = types.SimpleNamespace(**given | {n: draw.uniform(*of) for n, of in ends.items()})
                one = constants_of(block, sensor, 1e-4)
                for name, mine, all_of in zip(one._fields, one, whole, strict=True):
                    if isinstance(all_of, Ball):
                        assert inside(mine, all_of), f"{kind.__name__}.{name} with a tolerance of {part}"
                        seen.add(kind.__name__)
    assert len(seen) > 40
    assert len(silent - seen) < len(seen) / 4, f"no box has an answer of {sorted(silent - seen)}"
