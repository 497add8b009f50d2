"""Loops with several values of their wire in a period, as products of small maps: against dense algebra and by hand."""

import math

import numpy as np
import pytest
import scipy.optimize

from proofmass import margins
from proofmass.blocks import Constant, Difference, DiscreteIntegrator, Product, RepeatingSequence
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation import tick_maps
from proofmass.runner.analysis.linearisation.period_map import period_map
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps, maps_of_lifted
from proofmass.runner.analysis.linearisation.tick_products import joined
from proofmass.runner.host.arrays import Array
from proofmass.runner.planning.plan import plan

STATES = (("x", "first", -1), ("x", "second", -1), ("y", "state", -1))


def random_maps(seed: int, ticks: int) -> TickMaps:
    """A stable loop of three states, whose maps differ from value to value."""
    dice = np.random.default_rng(seed)
    a = 0.9 * np.linalg.qr(dice.normal(size=(ticks, 3, 3)))[0]
    b, c = 0.3 * dice.normal(size=(ticks, 3)), 0.3 * dice.normal(size=(ticks, 3))
    return TickMaps(a, b, c, np.zeros(ticks), dict(zip(STATES, range(3), strict=True)))


def whole(maps: TickMaps) -> tuple[Array, Array, Array, Array]:
    """A, B, C and D of the period, value by value."""
    ticks = len(maps.d)
    a, b, c, d = np.eye(3), np.zeros((3, ticks)), np.zeros((ticks, 3)), np.zeros((ticks, ticks))
    for k in range(ticks):
        c[k], d[k] = maps.c[k] @ a, maps.c[k] @ b
        a, b = maps.a[k] @ a, maps.a[k] @ b
        b[:, k] += maps.b[k]
    return a, b, c, d


@pytest.mark.parametrize("ticks", [1, 2, 3, 7, 16, 31])
def test_a_period_is_the_product_of_its_values(ticks: int) -> None:
    maps = random_maps(ticks, ticks)
    a, b, c, d = whole(maps)
    assert maps.lifted(STATES) == pytest.approx(np.block([[a, b], [c, d]]), abs=1e-14)
    for factor in (1.0, -0.7, 0.3 - 0.4j):
        closed = a + factor * b @ np.linalg.solve(np.eye(ticks) - factor * d, c)
        assert maps.closed(STATES, factor) == pytest.approx(closed, abs=1e-13)
        assert maps_of_lifted(STATES, a, b, c, d).closed(STATES, factor) == pytest.approx(closed, abs=1e-13)
    factors = np.array([0.1, 1.0, 5.0])
    expected = [math.log(max(abs(np.linalg.eigvals(maps.closed(STATES, factor))))) for factor in factors.tolist()]
    assert maps.growths(factors) == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("pattern", ["110", "0110100", "01001010", "10100"])
def test_ticks_without_a_value_of_the_wire_join_those_with_one(pattern: str) -> None:
    """One tick after the other: x' = A x + B u, y = C x, with u and y where there is a value."""
    dice, valued = np.random.default_rng(7), [digit == "1" for digit in pattern]
    maps, now = 0.5 * dice.normal(size=(len(pattern), 3, 3)), dice.normal(size=2)
    state, expected, found = now, list[float](), list[float]()
    places = np.nonzero(maps)
    for a, b, c, _ in zip(*joined(2, 0, np.array(valued), *places, maps[places]), strict=True):
        found.append(c @ state)
        state = a @ state + b
    for tick, has in zip(maps, valued, strict=True):
        expected += [tick[2, :2] @ now] * has
        now = tick[:2, :2] @ now + tick[:2, 2] * has
    assert found == pytest.approx(expected, rel=1e-12)
    assert state == pytest.approx(now, rel=1e-12)


@pytest.mark.parametrize("ticks", [1, 2, 7, 8, 9, 31])
def test_many_factors_side_by_side_are_each_alone(ticks: int) -> None:
    maps = random_maps(200 + ticks, ticks)
    a, b, c, d = whole(maps)
    for factors in (np.linspace(-3.0, 3.0, 40), np.exp(1j * np.linspace(0.0, math.pi, 40))):
        closed = [a + factor * b @ np.linalg.solve(np.eye(ticks) - factor * d, c) for factor in factors.tolist()]
        expected = [math.log(max(abs(np.linalg.eigvals(one)))) for one in closed]
        assert maps.growths(factors) == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("ends", [1.0, 2.0])
def test_growth_beyond_all_numbers_and_back_is_exact(ends: float) -> None:
    """The state grows by 2^200 a value, 300 times, shrinks as often, and is left `ends` times as large, less f / 8."""
    scale = np.concatenate([np.full(300, 2.0**200), np.full(300, 2.0**-200), [ends]])
    entered = np.concatenate([np.zeros(600), [0.125]])
    maps = TickMaps(scale[:, None, None], entered[:, None], np.ones((601, 1)), np.zeros(601), {STATES[0]: 0})
    factors = -np.linspace(0.0, 7.0, 15)
    assert maps.growths(factors) == pytest.approx(np.log(ends + 0.125 * factors), abs=1e-10)
    assert maps.growths(factors[:3]) == pytest.approx(np.log(ends + 0.125 * factors[:3]), abs=1e-10)


@pytest.mark.defect("S949", before="less than all numbers is taken for more: unstable", after="nothing is left")
@pytest.mark.parametrize("count", [1, 20])
def test_what_shrinks_below_all_numbers_is_gone(count: int) -> None:
    """1e-40 a value is 1e-320 after eight, which has no inverse."""
    nothing = np.zeros((16, 1))
    maps = TickMaps(np.full((16, 1, 1), 1e-40), nothing, nothing, np.zeros(16), {STATES[0]: 0})
    assert (maps.growths(np.ones(count)) <= 16 * math.log(1e-40)).all()


def test_a_wire_without_states_forgets_at_once() -> None:
    nothing = np.zeros((5, 0))
    maps = TickMaps(np.zeros((5, 0, 0)), nothing, nothing, np.zeros(5), {})
    assert maps.growths(np.ones(20)).tolist() == [-math.inf] * 20


@pytest.mark.exhaustive("0.5-12", "0.5-33")
@pytest.mark.parametrize("ticks", [1, 2, 5, 12, 33])
@pytest.mark.parametrize("offset", [0.5, 1.0])
def test_levels_are_crossed_where_a_singular_value_is_at_them(ticks: int, offset: float) -> None:
    maps = random_maps(100 + ticks, ticks)
    a, b, c, d = whole(maps)
    inverse = np.linalg.inv(np.eye(ticks) - d)
    closed, entry, out, direct = a + b @ inverse @ c, b @ inverse, inverse @ c, offset * np.eye(ticks) + d @ inverse

    def values(angle: float) -> Array:
        z = np.exp(1j * angle)
        return np.linalg.svd(out @ np.linalg.solve(z * np.eye(3) - closed, entry) + direct, compute_uv=False)

    around = np.array([values(angle) for angle in np.linspace(0.0, math.pi, 401)])
    for level in np.linspace(offset * 1.001, 1.2 * around.max(), 9).tolist():
        crossed = maps.crossed(level, offset, 1e-8)
        for angle in crossed:
            assert min(abs(values(angle) - level)) < 1e-6 * level
        above = around > level
        assert bool(crossed) == bool((above != above[0]).any())


@pytest.mark.exhaustive("255-2")
@pytest.mark.parametrize(("length", "seed"), [(31, 1), (255, 2), pytest.param(1023, 3, marks=pytest.mark.exhaustive)])
def test_a_loop_whose_gain_follows_a_sequence(length: int, seed: int) -> None:
    """x' = (1 - 0.4 w f) x with weights w of 0.55 and 1.45: a turn is a product, which may grow within."""
    weights = 1.0 + 0.45 * np.random.default_rng(seed).choice([-1.0, 1.0], length)
    blocks: dict[str, Block] = {
        "weights": RepeatingSequence(values=tuple(weights.tolist())),
        "error": Difference(),
        "product": Product(),
        "integrator": DiscreteIntegrator(gain=400.0, input_unit="1", output_unit="1"),
    }
    wires = ["weights.output -> product.second", "error.output -> product.first", "product.output -> integrator.input"]
    wires += ["integrator.output -> error.second", "zero.output -> error.first"]
    graph = Graph(name="weighted", rate="1 kHz", blocks={**blocks, "zero": Constant(value=0.0)}, wires=wires)
    found = margins(graph, "integrator.output")

    def growth(factor: float) -> float:
        return float(np.sum(np.log(np.abs(1.0 - 0.4 * factor * weights))))

    grid = np.linspace(1.0, 9.0, 4001)
    unstable = grid[np.flatnonzero([growth(factor) > 0.0 for factor in grid.tolist()])[0]]
    limit = scipy.optimize.brentq(growth, unstable - 3e-3, unstable)
    assert found.system.per_period == length
    assert found.gain_margin == pytest.approx(limit, rel=1e-9)
    assert found.slowest[0].value.real == pytest.approx(np.prod(1.0 - 0.4 * weights), rel=1e-9, abs=1e-300)


def test_a_period_whose_ticks_are_too_large_is_taken_as_a_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """x' = x + T w u, y = -x, over 80 ticks."""
    monkeypatch.setattr(tick_maps, "_MOST_ENTRIES", 0)
    weights = np.random.default_rng(6).normal(size=80)
    blocks = {"weights": RepeatingSequence(values=tuple(weights.tolist())), "error": Difference(), "product": Product()}
    blocks |= {"integrator": DiscreteIntegrator(output_unit="1"), "zero": Constant(value=0.0)}
    wires = ["weights.output -> product.second", "error.output -> product.first", "product.output -> integrator.input"]
    wires += ["integrator.output -> error.second", "zero.output -> error.first"]
    planned, node = plan(Graph(name="", rate="1 kHz", blocks=blocks, wires=wires)), ("error", "output")
    a, b, c, d = period_map(planned, [node], [node], cut=True, span=80).parts()
    assert a == pytest.approx(1.0)
    assert b[0] == pytest.approx(1e-3 * weights)
    assert c == pytest.approx(-1.0)
    assert d == pytest.approx(-1e-3 * np.tril(np.tile(weights, (80, 1)), -1))


def test_levels_are_crossed_with_a_direct_path() -> None:
    """One state: y = c x + d u is fed back as it is, and T = y / (y - 1) crosses each level where it has that size."""
    a, b, c, d = 0.5, 1.0, 0.1, 0.4
    maps = TickMaps(np.full((1, 1, 1), a), np.array([[b]]), np.array([[c]]), np.array([d]), {STATES[0]: 0})

    def size(angle: float) -> float:
        answer = c * b / (np.exp(1j * angle) - a) + d
        return float(abs(1.0 + answer / (1.0 - answer)))

    ends = sorted([size(0.0), size(math.pi)])
    assert ends == pytest.approx([1.5, 2.5])
    for level in (1.2, 1.7, 2.2, 2.7):
        inside = ends[0] < level < ends[1]
        angles = maps.crossed(level, 1.0, 1e-8)
        assert bool(angles) == inside, (level, ends)
        assert [size(angle) for angle in angles] == pytest.approx([level] * len(angles), rel=1e-9)


def test_what_the_wire_feeds_back_is_scaled_before_it_leaves_the_range_of_numbers() -> None:
    """x' = (0.5 + 1e50 f) x, 32 values of the wire in a period."""
    ticks, factors = 32, np.linspace(0.1, 1.0, 20)
    maps = TickMaps(
        np.full((ticks, 1, 1), 0.5), np.ones((ticks, 1)), np.full((ticks, 1), 1e50), np.zeros(ticks), {STATES[0]: 0}
    )
    assert maps.growths(factors) == pytest.approx(ticks * np.log(0.5 + 1e50 * factors), rel=1e-12)
