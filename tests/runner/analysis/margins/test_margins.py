"""Poles and margins of random sampled loops against systems built by hand for scipy and python-control."""

import cmath
import math
import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import control
import numpy as np
import pytest
import scipy.optimize
import scipy.signal

from proofmass.blocks import (
    Constant,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    Gain,
    Negation,
    Sum,
    TransferFunction,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.run.simulate import simulate
from tests.by_hand.amounts import chosen

FAST = 10_000.0


class Case(NamedTuple):
    """A loop: plant in s, fast delays behind it, a slow controller in z with delays of its own."""

    plant: tuple[list[float], list[float]]
    fast_delays: int
    ratio: int
    controller: tuple[list[float], list[float]]
    slow_delays: int


def random_case(number: int) -> Case:
    """Stable plant of order 1 to 4 below half the slow rate, mild controller, a gain drawn about one."""
    dice = random.Random(number)
    ratio = dice.choice([1, 1, 2, 3, 5])
    slow = FAST / ratio
    roots: list[complex] = []
    for _ in range(dice.randrange(1, 3)):
        w = 2.0 * math.pi * slow * math.exp(dice.uniform(-6.0, -1.2))
        damping = dice.uniform(0.05, 0.95)
        pair = complex(-damping * w, w * math.sqrt(1.0 - damping**2))
        roots += dice.choice([[complex(-w)], [pair, pair.conjugate()]])
    denominator = np.real(np.poly(roots)).tolist()
    numerator = [denominator[-1] * dice.choice([0.1, 0.3, 1.1, 3.0]) * dice.choice([1.0, 1.0, -1.0])]
    kind = dice.randrange(3)
    if kind == 0:
        controller = ([1.0, 0.0], [1.0, 0.0])
    elif kind == 1:
        controller = ([0.2, 0.1], [1.0, -dice.uniform(0.2, 0.999)])
    else:
        pole = dice.uniform(0.1, 0.9)
        controller = ([0.5, -0.3 * pole, 0.05], [1.0, -(1.0 + pole), pole])  # an integrator and a pole
    return Case((numerator, denominator), dice.randrange(3), ratio, controller, dice.randrange(1, 4))


def graph_of(case: Case, opened: str = "out.output") -> Graph:
    """The loop in blocks; opened at a slow wire it is one sampled system."""
    blocks: dict[str, Block] = {"plant": TransferFunction(numerator=case.plant[0], denominator=case.plant[1])}
    wires, last = [], "plant.strictly_proper_part"
    for number in range(case.fast_delays):
        blocks[f"fast_{number}"] = UnitDelay()
        wires.append(f"{last} -> fast_{number}.input")
        last = f"fast_{number}.output"
    blocks["minus"] = Gain(gain=-1.0)
    blocks["controller"] = DiscreteTransferFunction(numerator=case.controller[0], denominator=case.controller[1])
    blocks["out"] = DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, *[0.0] * case.slow_delays))
    wires += [f"{last} -> minus.input", "minus.output -> controller.input", "controller.output -> out.input"]
    wires.append("out.output -> plant.input")
    slow = Fraction(10_000, case.ratio)
    return Graph(
        name="random loop",
        rate=FAST,
        blocks=blocks,
        rates={"controller": slow, "out": slow, "minus": slow},
        wires=wires,
        probes=["out.output"],
        loops={"main": {"open_at": opened}},
    )


def by_hand(case: Case) -> Any:
    """L(z) at the slow rate as a python-control system: the plant held and delayed at the fast rate, then sampled."""
    a, b, c, _, _ = scipy.signal.cont2discrete(scipy.signal.tf2ss(*case.plant), 1.0 / FAST, method="zoh")
    n, delays = len(a), case.fast_delays
    fast_a = np.zeros((n + delays, n + delays))
    fast_b = np.zeros((n + delays, 1))
    fast_a[:n, :n], fast_b[:n] = a, b
    for i in range(delays):
        fast_a[n + i, :n] = c if i == 0 else 0.0
        if i:
            fast_a[n + i, n + i - 1] = 1.0
    fast_c = np.zeros((1, n + delays))
    if delays:
        fast_c[0, -1] = 1.0
    else:
        fast_c[0, :n] = c
    slow_a = np.linalg.matrix_power(fast_a, case.ratio)
    slow_b = sum((np.linalg.matrix_power(fast_a, i) @ fast_b for i in range(case.ratio)), np.zeros_like(fast_b))
    period = case.ratio / FAST
    plant = control.ss(slow_a, slow_b, fast_c, [[0.0]], period)
    numerator, denominator = case.controller
    controller = control.ss(control.tf(numerator, denominator, period))
    delay = control.ss(control.tf([1.0], [1.0, *[0.0] * case.slow_delays], period))
    return plant * delay * controller


def poles_by_hand(system: Any) -> np.ndarray:  # type: ignore[type-arg]
    poles = control.feedback(system, 1).poles()
    return np.array(poles[np.abs(poles) > 0.05])  # registers of delays, at zero, are known to rounding^(1/n) only


def response(system: Any, w: Any) -> Any:
    """The answer at angular frequencies; python-control takes them one by one, in 0.1 ms each."""
    z = np.exp(1j * np.atleast_1d(w) * system.dt)[:, None, None]
    value = system.C @ np.linalg.solve(z * np.eye(system.nstates) - system.A, system.B + 0.0 * z) + system.D
    return value[:, 0, 0] if np.ndim(w) else value[0, 0, 0]


def margins_by_hand(system: Any) -> tuple[float, float]:
    """Gain factor above 1 and phase in rad, from a dense grid refined by a root finder."""
    last = math.pi / system.dt
    w = np.unique(np.concatenate([np.geomspace(1e-5 * last, last, 1200), np.linspace(1e-5 * last, last, 600)]))
    values = response(system, w)
    factors = [-1.0 / values[-1].real if values[-1].real < 0.0 else math.inf]
    for i in np.flatnonzero(np.diff(np.sign(values.imag[:-1])) != 0):
        at = scipy.optimize.brentq(lambda v: response(system, v).imag, w[i], w[i + 1], xtol=1e-13)
        real = response(system, at).real
        factors.append(-1.0 / real if real < 0.0 else math.inf)
    if np.min(np.abs(system.poles() - 1.0)) > 1e-9 and response(system, 0.0).real < 0.0:
        factors.append(-1.0 / response(system, 0.0).real)
    phases = [math.inf]
    for i in np.flatnonzero(np.diff(np.sign(np.abs(values) - 1.0)) != 0):
        at = scipy.optimize.brentq(lambda v: abs(response(system, v)) - 1.0, w[i], w[i + 1], xtol=1e-13)
        phases.append(abs(cmath.phase(-complex(response(system, at)))))
    return min((f for f in factors if f > 1.0), default=math.inf), min(phases)


@pytest.mark.parametrize("numbers", chosen([(5, 10, 14, 18)], [range(200)]), ids=len)
def test_random_loops(numbers: Sequence[int]) -> None:
    seen = {"stable": 0, "two rates": 0, "delays": 0, "margins": 0, "unstable": 0}
    for number in numbers:
        case = random_case(number)
        system = by_hand(case)
        found = margins(graph_of(case))
        assert found.system.per_period == 1
        expected = poles_by_hand(system)
        for pole in expected:
            assert np.min(np.abs(found.poles - pole)) < 1e-6, number
        assert found.stable == bool(np.all(np.abs(expected) < 1.0)), number
        seen["two rates"] += case.ratio > 1
        seen["delays"] += case.fast_delays > 0
        if not found.stable:
            assert found.gain_margin is None
            assert found.phase_margin is None
            seen["unstable"] += 1
            continue
        seen["stable"] += 1
        gain, phase = margins_by_hand(system)
        assert (found.gain_margin or math.inf) == pytest.approx(gain, rel=1e-6), number
        assert (math.inf if found.phase_margin is None else found.phase_margin) == pytest.approx(phase, abs=1e-6), (
            number
        )
        seen["margins"] += found.gain_margin is not None and found.phase_margin is not None
    assert min(seen.values()) >= len(numbers) / 8, seen


@pytest.mark.exhaustive
def test_a_loop_opened_at_a_fast_wire_has_the_margins_of_the_slow_one() -> None:
    """A factor and a turn do the same wherever they stand; the fast wire has several values in a period."""
    compared = 0
    for number in range(30):
        case = random_case(number)
        if case.ratio == 1 or case.fast_delays == 0:
            continue
        slow = margins(graph_of(case))
        fast = margins(graph_of(case, opened="fast_0.output"))
        assert fast.system.per_period == case.ratio
        assert fast.period == slow.period
        assert np.abs(fast.poles)[:3] == pytest.approx(np.abs(slow.poles)[:3], abs=1e-6), number
        assert fast.stable == slow.stable
        if slow.stable:
            for name in ("gain_margin", "gain_reduction", "phase_margin"):
                got, expected = getattr(fast, name) or math.inf, getattr(slow, name) or math.inf
                assert got == pytest.approx(expected, rel=1e-6), (number, name)
            compared += 1
    assert compared >= 5


def lifted(ratio: int, gain: float = 0.3) -> Graph:
    """One fast loop; with a ratio a slow register whose value counts nothing makes a period of several ticks."""
    blocks: dict[str, Block] = {
        "plant": TransferFunction(numerator=(3e4,), denominator=(1.0, 400.0, 3e5)),
        "delay": UnitDelay(),
        "minus": Negation(),
        "controller": DiscreteTransferFunction(numerator=(gain, -0.83 * gain), denominator=(1.0, -1.0)),
        "sum": Sum(),
    }
    wires = [
        "plant.strictly_proper_part -> delay.input",
        "delay.output -> minus.input",
        "minus.output -> controller.input",
        "controller.output -> sum.first",
        "sum.output -> plant.input",
    ]
    if ratio == 1:
        blocks["nothing"] = Constant(value=0.0)
        wires.append("nothing.output -> sum.second")
    else:
        blocks |= {"slow": UnitDelay(), "nothing": Gain(gain=0.0)}
        wires += ["controller.output -> slow.input", "slow.output -> nothing.input", "nothing.output -> sum.second"]
    rates = {"slow": Fraction(10_000, ratio)} if ratio > 1 else {}
    opened = {"main": {"open_at": "sum.output"}}
    return Graph(name="lifted", rate=FAST, blocks=blocks, rates=rates, wires=wires, loops=opened)


@pytest.mark.exhaustive("7-2.0")
@pytest.mark.parametrize(("ratio", "gain"), [(2, 0.3), (3, 2.0), (7, 2.0)])
def test_lifting_changes_no_margin(ratio: int, gain: float) -> None:
    plain, found = margins(lifted(1, gain)), margins(lifted(ratio, gain))
    assert plain.system.per_period == 1
    assert found.system.per_period == ratio
    assert found.stable
    assert plain.stable
    assert np.sort(np.abs(found.poles))[-3:] == pytest.approx(np.sort(np.abs(plain.poles**ratio))[-3:], rel=1e-9)
    for name in ("gain_margin", "phase_margin", "disk_margin", "sensitivity_peak", "bandwidth"):
        assert getattr(found, name) == pytest.approx(getattr(plain, name), rel=1e-6), name
    for name in ("gain_crossovers", "phase_crossovers"):
        assert getattr(found, name) == pytest.approx(getattr(plain, name), rel=1e-6), name
    assert plain.delay_margin is not None
    assert found.delay_margin == pytest.approx(math.floor(plain.delay_margin * FAST) / FAST)


def test_an_unstable_loop_has_no_margins_and_a_limitless_one_none() -> None:
    wild = lifted(1).with_parameters({"controller.numerator": [30.0, -25.0]})
    found = margins(wild)
    assert not found.stable
    assert abs(found.poles[0]) > 1.0
    assert found.gain_margin is found.phase_margin is found.sensitivity_peak is None
    quiet = Graph(
        name="integrator",
        rate=FAST,
        blocks={"integral": DiscreteIntegrator(output_unit="1", gain=-100.0)},
        wires=["integral.output -> integral.input"],
    )
    calm = margins(quiet)  # L = 0.01 / (z - 1): a real pole at 1 - 0.01 k, so k may rise to 200
    assert calm.gain_margin == pytest.approx(200.0, rel=1e-9)
    assert calm.gain_reduction is None
    assert calm.poles == pytest.approx([0.99])
    # |L| = 1 where 2 sin(w T / 2) = 0.01; its phase is -90 degrees less w T / 2.
    half = math.asin(0.005)
    assert calm.phase_margin == pytest.approx(math.pi / 2.0 - half, rel=1e-9)
    assert calm.gain_crossovers == pytest.approx([2.0 * half * FAST / (2.0 * math.pi)], rel=1e-9)


def test_a_dip_between_two_frequencies_is_found() -> None:
    """A resonance a millionth of its frequency wide lifts |L| above one: no grid of its own would see it."""
    damping = 1e-6
    w = 2.0 * math.pi * 1234.5
    sharp = Graph(
        name="resonance",
        rate=FAST,
        blocks={
            "plant": TransferFunction(numerator=(1e-5 * w * w,), denominator=(1.0, 2.0 * damping * w, w * w)),
            "minus": Negation(),
        },
        wires=["plant.strictly_proper_part -> minus.input", "minus.output -> plant.input"],
        rates={"minus": FAST},  # a rate of its own: it works at ticks, and does not belong to the continuous group
    )
    found = margins(sharp, "minus.output")
    assert len(found.gain_crossovers) == 2
    assert found.gain_crossovers == pytest.approx([1234.5, 1234.5], rel=1e-5)


def test_a_loop_that_passes_every_frequency_alike_has_no_crossover() -> None:
    """L = 1/z: its size is one everywhere, to rounding; the closed loop has its pole at -1."""
    blocks: dict[str, Block] = {"delay": UnitDelay(), "back": Gain(gain=-1.0)}
    wires = ["delay.output -> back.input", "back.output -> delay.input"]
    found = margins(Graph(name="ring", rate=FAST, blocks=blocks, wires=wires))
    assert not found.stable
    assert found.gain_crossovers == ()


def test_a_peak_at_rest_is_found_there() -> None:
    """L = -0.3 / z: |S| = 1 / |1 - 0.3 / z| is largest at z = 1."""
    blocks: dict[str, Block] = {"delay": UnitDelay(), "back": Gain(gain=0.3)}
    wires = ["delay.output -> back.input", "back.output -> delay.input"]
    found = margins(Graph(name="ring", rate=FAST, blocks=blocks, wires=wires), "delay.output")
    assert found.sensitivity_peak == pytest.approx(1.0 / 0.7, rel=1e-14)
    assert found.sensitivity_peak_frequency == 0.0
    assert found.disk_margin == pytest.approx(2.0 * 0.7 / 1.3, rel=1e-14)


@pytest.mark.parametrize("ratio", chosen([1, 3], [2]))
def test_a_simulated_loop_decays_a_thousandth_below_its_gain_margin_and_grows_above(ratio: int) -> None:
    """The first random loop of that ratio of rates with a delay, whose register holds a push, and a gain margin."""
    delayed = (case for case in map(random_case, range(200)) if case.fast_delays and case.ratio == ratio)
    stable = (case for case in delayed if np.all(np.abs(poles_by_hand(by_hand(case))) < 1.0))
    case, limit = next((case, limit) for case in stable if (limit := margins(graph_of(case)).gain_margin))
    assert _growth(case, 0.999 * limit) < 1.0 < _growth(case, 1.001 * limit)


@pytest.mark.exhaustive
@pytest.mark.parametrize("count", [50])
def test_simulated_loops_decay_inside_their_gain_margin_and_grow_outside(count: int) -> None:
    """A thousandth of the factor on either side; each runs for half a time constant of the growth that is expected."""
    tried = 0
    for case in (case for case in map(random_case, range(1000)) if case.fast_delays):
        limit = margins(graph_of(case)).gain_margin
        if limit is None:
            continue
        slowest = min(abs(margins(_pushed(case, part * limit)).slowest[0].distance) for part in (0.999, 1.001))
        periods = 300 * math.ceil(0.6 / slowest / 300)
        if periods * case.ratio <= 10_000:
            tried += 1
            assert _growth(case, 0.999 * limit, periods) < 1.0 < _growth(case, 1.001 * limit, periods), case
        if tried == count:
            return
    pytest.fail(f"only {tried} loops have a margin")


def _growth(case: Case, factor: float, periods: int = 3_000) -> float:
    """How much larger the swings are in the last third of a run than in the one before."""
    run = simulate(_pushed(case, factor), samples=periods * case.ratio, engine="compiled")
    third = periods // 3
    before, last = np.abs(run["out.output"].values[-2 * third :]).reshape(2, third).max(axis=1)
    return float(last / before)


def _pushed(case: Case, factor: float) -> Graph:
    return graph_of(case).with_parameters({f"fast_{case.fast_delays - 1}.initial": 1.0, "minus.gain": -factor})
