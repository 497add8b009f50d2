"""Loops that remember in rings: delay lines of any length, own ones too, and choppers of any half period.

The truth is the characteristic polynomial that the graph's equations give, written here by hand.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pytest

from proofmass import linearise, margins, noise, run_study, simulate
from proofmass.blocks import (
    ChopperModulator,
    Constant,
    Delay,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    FractionalDelay,
    Gain,
    MovingAverage,
    Power,
    Sum,
    UnitDelay,
    WhiteNoise,
)
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.loops import Loop
from proofmass.graphs.studies.build import Study
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.analysis.linearisation.rings import Ring as FoundRing
from proofmass.runner.analysis.linearisation.rings import Rings
from tests.by_hand.amounts import amounts

RATE = 1000
STEP = 0.1  # of the integrator, for an input of one


class Ring(Block):
    """A delay line in a ring of eight that may be longer than the delay."""

    ticks: int = param("1", "Delay.", default=2, at_least=1, at_most=7)
    stride: int = param("1", "Cells from one place to the next.", default=1, at_least=1, at_most=7)

    input = Input("1", "Signal to delay.")

    line = Buffer("The last inputs.", float, (8,))


class State(NamedTuple):
    place: int


@Ring.output("1")
def output(p: Ring, x: State, line: list[float]) -> float:
    """The input so many ticks before."""
    return line[(x.place - p.ticks * p.stride) % 8]


@Ring.update
def update(p: Ring, x: State, line: list[float], input: float) -> State:
    line[x.place] = input
    return State((x.place + p.stride) % 8)


class ClockRing(Block):
    """A delay line of five ticks in a ring whose place follows the time, not the state."""

    input = Input("1", "Signal to delay.")

    line = Buffer("The last inputs.", float, (5,))


@ClockRing.output("1")
def oldest(p: ClockRing, line: list[float], tick: int) -> float:
    """The input five ticks before."""
    return line[tick % 5]


@ClockRing.update
def write(p: ClockRing, line: list[float], input: float, tick: int) -> None:
    line[tick % 5] = input


def loop(delay: Block, port: str = "output", sign: float = -1.0) -> Graph:
    """An integrator behind a delay, in feedback."""
    return Graph(
        name="delayed",
        rate=RATE,
        blocks={
            "integral": DiscreteIntegrator(gain=STEP * RATE, output_unit="1", initial=1.0),
            "delay": delay,
            "back": Gain(gain=sign),
        },
        wires=["integral.output -> delay.input", f"delay.{port} -> back.input", "back.output -> integral.input"],
        probes=["integral.output"],
        duration="1 s",
    )


def limit(taps: Sequence[float], sign: float = -1.0) -> float:
    """The largest factor with which z - 1 = sign f STEP sum of taps[i] z^-i has its roots within the circle; or 0."""

    def largest(factor: float) -> float:
        polynomial = np.zeros(len(taps) + 1)
        polynomial[:2] = 1.0, -1.0
        polynomial[1:] -= sign * factor * STEP * np.asarray(taps)
        return float(np.max(np.abs(np.roots(polynomial))))

    low, high = 0.0, 100.0
    if largest(1e-6) >= 1.0:
        return 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if largest(middle) < 1.0 else (low, middle)
    return low


def after(ticks: int) -> list[float]:
    return [0.0] * ticks + [1.0]


def lagrange(delay: float) -> list[float]:
    """Taps of the cubic through four samples about the place between the samples."""
    first = int(delay) - 1
    d = delay - first
    weights = [np.prod([(d - j) / (i - j) for j in range(4) if j != i]) for i in range(4)]
    return [0.0] * first + [float(weight) for weight in weights]


@pytest.mark.defect("S500", before="the delay line is not in the loop", after="margins of the whole ring")
@pytest.mark.parametrize(
    ("delay", "taps"),
    [
        (FractionalDelay(delay=1.5, longest=8), lagrange(1.5)),
        (FractionalDelay(delay=7.25, longest=64), lagrange(7.25)),
        (Ring(ticks=2), after(2)),
        (Ring(ticks=3, stride=3), after(3)),
        (Ring(ticks=7, stride=5), after(7)),
        (ClockRing(), after(5)),
    ],
)
def test_a_ring_longer_than_its_delay_is_in_the_loop(delay: Block, taps: list[float]) -> None:
    port = "oldest" if isinstance(delay, ClockRing) else "output"
    found = margins(loop(delay, port), "back.output")
    assert found.stable == (limit(taps) > 1.0)
    assert found.stable_gains[0][1] == pytest.approx(limit(taps), rel=1e-6)
    assert bool(found.system.map.notes) == isinstance(delay, ClockRing), "a shift register is alike in each tick"


@pytest.mark.defect("S501", before="stable, +50.10 dB", after="unstable")
def test_positive_feedback_through_a_ring_is_unstable() -> None:
    graph = loop(FractionalDelay(delay=1.5, longest=8), sign=1.0)
    values = simulate(graph, samples=200)["integral.output"].values
    assert values[-1] > 1e5
    assert margins(graph, "back.output").verdict == "unstable"


@pytest.mark.defect("S502", before="a delay of two ticks as it stands in tick 0: 34.19 dB", after="30.83 dB")
def test_a_ring_of_two_has_both_its_cells() -> None:
    """z (z - 1) (z - 0.9) z = -f 0.01 0.1: the delay of two and the low-pass."""
    graph = loop(Delay(ticks=2))
    blocks = dict(graph.blocks) | {"low": DiscreteTransferFunction(numerator=(0.1,), denominator=(1.0, -0.9))}
    blocks["integral"] = DiscreteIntegrator(gain=10.0, output_unit="1")
    wires = ["integral.output -> low.input", "low.strictly_proper_part -> delay.input"]
    wires += ["delay.output -> back.input", "back.output -> integral.input"]
    found = margins(Graph(name="two", rate=RATE, blocks=blocks, wires=wires, duration="20 ms"), "back.output")

    def size(factor: float) -> float:
        polynomial = np.polymul([1.0, 0.0, 0.0], np.polymul([1.0, -1.0], [1.0, -0.9]))
        return float(np.max(np.abs(np.roots(np.polyadd(polynomial, [factor * 1e-3])))))

    assert found.gain_margin is not None
    assert size(found.gain_margin * (1.0 - 1e-6)) < 1.0 < size(found.gain_margin * (1.0 + 1e-6))
    assert 20.0 * np.log10(found.gain_margin) == pytest.approx(30.83, abs=0.01)


@pytest.mark.defect("S503", before="x 60, as the chopper stands in tick 0", after="x 20, over its period of two ticks")
def test_a_chopper_that_changes_in_every_tick_is_a_turn_of_two() -> None:
    """A low-pass 0.5 z / (z - 0.5) between choppers is 0.5 z / (z + 0.5): 1 + f 0.1 0.5 z / ((z - 1) (z + 0.5))."""
    blocks: dict[str, Block] = {
        "integral": DiscreteIntegrator(gain=STEP * RATE, output_unit="1", initial=1.0),
        "into": ChopperModulator(unit="1"),
        "low": DiscreteTransferFunction(numerator=(0.5, 0.0), denominator=(1.0, -0.5)),
        "out": ChopperModulator(unit="1"),
        "back": Gain(gain=-1.0),
    }
    wires = ["integral.output -> into.input", "into.output -> low.input", "low.output -> out.input"]
    wires += ["out.output -> back.input", "back.output -> integral.input"]
    graph = Graph(name="chopped", rate=RATE, blocks=blocks, wires=wires, probes=["integral.output"], duration="1 s")
    found = margins(graph, "integral.output", at="0 s")

    def size(factor: float) -> float:
        return float(np.max(np.abs(np.roots([1.0, -0.5 + 0.05 * factor, -0.5]))))

    assert found.gain_margin is not None
    assert size(found.gain_margin * (1.0 - 1e-6)) < 1.0 < size(found.gain_margin * (1.0 + 1e-6))


@pytest.mark.defect("S504", before="a slow pole behind a delay is hidden: x 4.446", after="x 1.149")
def test_a_slow_pole_behind_a_delay_is_seen() -> None:
    """Positive feedback of 0.87 through a slow pole: unstable from 1 / 0.87 on, whatever the delay."""
    blocks: dict[str, Block] = {
        "out": UnitDelay(),
        "delay": Delay(ticks=5),
        "slow": DiscreteTransferFunction(numerator=(1e-6,), denominator=(1.0, -(1.0 - 1e-6))),
        "back": Gain(gain=0.87),
    }
    wires = ["out.output -> delay.input", "delay.output -> slow.input"]
    wires += ["slow.strictly_proper_part -> back.input", "back.output -> out.input"]
    found = margins(Graph(name="slow", rate=RATE, blocks=blocks, wires=wires), "out.output")
    assert found.gain_margin == pytest.approx(1.0 / 0.87, rel=1e-9)
    assert not found.hidden


@pytest.mark.exhaustive
def test_a_delay_is_a_shift_register() -> None:
    """One value of the wire in a period, and as many states as ticks."""
    system = linearise(loop(Delay(ticks=100)), loop="back.output")
    assert (system.ninputs, system.nstates) == (1, 101)
    found = margins(loop(Delay(ticks=100)), "back.output")
    assert found.stable_gains[0][1] == pytest.approx(limit(after(100)), rel=1e-6)


def test_an_average_that_begins_its_sum_anew_is_an_average() -> None:
    found = margins(loop(MovingAverage(length=4), "mean"), "back.output")
    assert found.period == 1.0 / RATE
    assert found.gain_margin == pytest.approx(limit([0.25] * 4), rel=1e-6)


@pytest.mark.defect("S505", before="a noise of 1.4, as if the loop had no delay", after="that of the whole loop")
def test_noise_passes_through_the_ring() -> None:
    """The integrator's output for white noise at its input, by the impulse response of the closed loop."""
    graph = loop(FractionalDelay(delay=1.5, longest=8))
    blocks = dict(graph.blocks) | {"noise": WhiteNoise(density=1.0), "sum": Sum()}
    wires = ["integral.output -> delay.input", "delay.output -> back.input", "back.output -> sum.first"]
    wires += ["noise.output -> sum.second", "sum.output -> integral.input"]
    found = noise(Graph(name="noisy", rate=RATE, blocks=blocks, wires=wires), "integral.output")
    taps, answer = lagrange(1.5), [0.0] * 2000
    for n in range(1, len(answer)):
        fed = sum(tap * answer[n - 1 - i] for i, tap in enumerate(taps) if n - 1 - i >= 0)
        answer[n] = answer[n - 1] - STEP * fed + (STEP if n == 1 else 0.0)
    assert found.rms == pytest.approx(np.sqrt(RATE / 2.0 * np.sum(np.square(answer))), rel=1e-9)


@pytest.mark.exhaustive
@pytest.mark.defect("S506", before="margins of a neighbour in 12 of 400 runs", after="equal with any threads")
@pytest.mark.parametrize("again", amounts(1, 3))
def test_margins_of_a_study_do_not_depend_on_threads(again: int) -> None:
    """y' = y / 2 + (b - y) |b - y| / 10, opened at two wires of the one loop: the margins are equal."""
    blocks: dict[str, Block] = {
        "bias": Constant(value=5.0), "error": Sum(), "minus": Gain(gain=-1.0), "square": Power(exponent=2.0, odd=True),
        "k": Gain(gain=0.1), "add": Sum(), "leak": Gain(gain=0.5), "hold": UnitDelay(),
    }  # fmt: skip
    wires = ["bias.output -> error.first", "hold.output -> minus.input", "minus.output -> error.second"]
    wires += ["error.output -> square.input", "square.output -> k.input", "k.output -> add.first"]
    wires += ["hold.output -> leak.input", "leak.output -> add.second", "add.output -> hold.input"]
    graph = Graph(
        name="race",
        rate=10_000,
        samples=200,
        blocks=blocks,
        wires=wires,
        probes=["hold.output"],
        loops={"main": Loop(open_at="minus.output"), "again": Loop(open_at="k.output")},
    )
    study = Study(graph=graph, runs=48, seed=1, margins="settled", spread={"bias.value": {"uniform": 0.1}})
    results = [run_study(study, threads=threads) for threads in (1, *[8] * again)]
    assert len({result.digest for result in results}) == 1
    table = results[0].values
    assert np.array_equal(table["main.gain_margin"], table["again.gain_margin"])


def test_the_slowest_ring_is_the_one_that_is_back_last() -> None:
    run = object.__new__(OrbitRun)
    run.rings = Rings(
        {(name, "line"): FoundRing("place", 5, turn, turn) for name, turn in (("a", 5), ("b", 40), ("c", 8))}
    )
    assert run.slowest_ring() == ("b", "b.line", 1.0 / 40.0)
