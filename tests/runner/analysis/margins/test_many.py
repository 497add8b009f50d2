"""Margins of many sensors at once: against the certified path one by one, alone and together, near limits."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import proofmass
from proofmass.blocks import (
    Constant,
    Difference,
    DiscreteTransferFunction,
    Gain,
    LowPass,
    Negation,
    Notch,
    Step,
    Sum,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.changes import changed_blocks
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.margins.many import ManyMargins, margins_alone
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from tests.by_hand.amounts import amounts, chosen
from tests.by_hand.polynomial_loops import sampled_loop


def lot(graph: Graph, spread: dict[str, float], count: int) -> tuple[Plan, list[Plan]]:
    """The plan of a graph, and those of sensors whose parameters are spread by a part of themselves."""
    planned, dice = plan(graph), np.random.default_rng(7)
    first = {key: getattr(planned.blocks[key.split(".")[0]], key.split(".")[1]) for key in spread}
    draws = [{k: first[k] * (1.0 + s * float(dice.normal())) for k, s in spread.items()} for _ in range(count)]
    return planned, [varied(planned, changed_blocks(planned.blocks, draw)) for draw in draws]


ACCELEROMETER = {"pendulum.stiffness": 0.05, "pendulum.damping": 0.1, "pendulum.inertia": 0.05, "torquer.gain": 0.1}


def test_sensors_in_turn_leave_nothing_for_the_next_one() -> None:
    """They share arrays, in which matrices of continuous blocks are kept as long as what they follow from stays."""
    planned, (first, second) = lot(proofmass.read_graph("library:closed_loop_accelerometer"), ACCELEROMETER, 2)
    many = ManyMargins(planned, "0 s")
    together = many.values([first, second, first])
    assert together[0] == together[2] != together[1]
    assert [*many.values([second]), *ManyMargins(planned, "0 s").values([second])] == [together[1]] * 2


@pytest.mark.exhaustive
@pytest.mark.parametrize("at", ["0 s", "2 ms"])
def test_an_accelerometer(at: str) -> None:
    graph = proofmass.read_graph("library:closed_loop_accelerometer")
    planned, sensors = lot(graph, ACCELEROMETER, 12)
    many = ManyMargins(planned, at)
    together = many.values(sensors)
    for sensor, values in zip(sensors, together, strict=True):
        assert values == pytest.approx(margins_alone(sensor, at), rel=1e-11)
    assert [many.values([sensor])[0] for sensor in sensors] == together
    assert ManyMargins(planned, at).values(sensors[::-1])[::-1] == together


def chain(gain: float, pole: float = 0.9) -> Graph:
    """A delay and a pole with a gain at the wire."""
    blocks: dict[str, Block] = {
        "zero": Constant(value=0.0),
        "error": Difference(),
        "gain": Gain(gain=gain),
        "pole": DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, -pole)),
        "delay": UnitDelay(),
    }
    wires = ["zero.output -> error.first", "delay.output -> error.second", "error.output -> gain.input"]
    wires += ["gain.output -> pole.input", "pole.strictly_proper_part -> delay.input"]
    loops = {"main": {"open_at": "delay.output"}}
    return Graph(name="", rate="1 kHz", duration="10 ms", blocks=blocks, wires=wires, loops=loops)


@pytest.mark.parametrize("count", amounts(5, 20))
def test_a_narrow_notch_at_the_phase_crossover_is_no_case_for_the_certified_path(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the notch L is zero, and a turn of phase each lies 0.1 % beside it."""
    graph = chain(0.5)
    notch = Notch(frequency=1000.0 * math.acos(0.45) / (2.0 * math.pi), quality=500.0)
    wires = [str(wire) for wire in graph.wires if str(wire) != "gain.output -> pole.input"]
    wires += ["gain.output -> notch.input", "notch.output -> pole.input"]
    graph = Graph(name="", rate="1 kHz", blocks={**graph.blocks, "notch": notch}, wires=wires, loops=graph.loops)
    planned, sensors = lot(graph, {"gain.gain": 0.1}, count)
    alone = [margins_alone(sensor, "0 s") for sensor in sensors]
    monkeypatch.setattr("proofmass.runner.analysis.margins.many.margins_alone", None)
    for values, expected in zip(ManyMargins(planned, "0 s").values(sensors), alone, strict=True):
        assert values == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("off", chosen([-1e-7, -1e-13, 0.0, 1e-13, 1e-7], [-1e-2, 1e-2]))
def test_a_sensor_next_to_its_limit_has_the_certified_verdict(off: float) -> None:
    """z^2 - 0.9 z + f is stable up to f = 1."""
    planned = plan(chain(0.5))
    sensor = varied(planned, changed_blocks(planned.blocks, {"gain.gain": 1.0 + off}))
    (values,) = ManyMargins(planned, "0 s").values([sensor])
    assert not isinstance(values, proofmass.ModelError)
    assert abs(off) < 1e-12 or values[-1] == float(off < 0.0)
    assert math.isnan(values[0]) == (values[-1] != 1.0)
    assert values == pytest.approx(margins_alone(sensor, "0 s"), rel=1e-9, nan_ok=True)


def test_an_instant_within_a_period_is_no_case_for_the_certified_path(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = chain(0.15)
    planned, sensors = lot(replace(graph, rates={"delay": "250 Hz"}), {"gain.gain": 0.1}, 1)
    alone = [margins_alone(sensor, "1 ms") for sensor in sensors]
    assert np.isfinite([values[0] for values in alone]).all()
    monkeypatch.setattr("proofmass.runner.analysis.margins.many.margins_alone", None)
    for values, expected in zip(ManyMargins(planned, "1 ms").values(sensors), alone, strict=True):
        assert values == pytest.approx(expected, rel=1e-9)


def test_a_sensor_without_a_crossover_of_its_kind_is_taken_alone() -> None:
    """|L| < 1 everywhere below f = 0.1: there is no phase margin."""
    planned = plan(chain(0.5))
    sensor = varied(planned, changed_blocks(planned.blocks, {"gain.gain": 0.05}))
    (values,) = ManyMargins(planned, "0 s").values([sensor])
    assert not isinstance(values, proofmass.ModelError)
    assert values[1] == math.inf
    assert values == pytest.approx(margins_alone(sensor, "0 s"), rel=1e-12)


def test_a_loop_of_analog_blocks_has_the_margin_of_three_lags() -> None:
    """Each turns by 60 deg at the frequency at which it halves."""
    lag = LowPass(corner_frequency=160.0)
    blocks = {"zero": Constant(), "error": Difference(), "gain": Gain(gain=4.0), "a": lag, "b": lag, "c": lag}
    wires = ["zero.output -> error.first", "c.output -> error.second", "error.output -> gain.input"]
    wires += ["gain.output -> a.input", "a.output -> b.input", "b.output -> c.input"]
    loops = {"main": {"open_at": "c.output"}}
    planned = plan(Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, loops=loops))
    sensor = varied(planned, changed_blocks(planned.blocks, {"gain.gain": 5.0}))
    ((gain_margin, *_),) = ManyMargins(planned, "0 s").values([sensor])
    assert gain_margin == pytest.approx(20.0 * math.log10(8.0 / 5.0))


def test_a_switch_at_another_time_is_not_that_of_the_first() -> None:
    """A step that adds to the reference of a loop through a product moves its gain at a time of its own."""
    graph = chain(0.5)
    blocks = {**graph.blocks, "step": Step(amplitude=0.2, start_time=0.0), "one": Constant(value=0.4), "sum": Sum()}
    wires = [*map(str, graph.wires), "step.output -> sum.first", "one.output -> sum.second", "sum.output -> gain.gain"]
    planned = plan(Graph(name="", rate="1 kHz", duration="1 s", blocks=blocks, wires=wires, loops=graph.loops))
    late = varied(planned, changed_blocks(planned.blocks, {"step.start_time": 0.5}))
    (values,) = ManyMargins(planned, "0 s").values([late])
    assert values == pytest.approx(margins_alone(late, "0 s"), rel=1e-12)
    assert values != pytest.approx(margins_alone(planned, "0 s"), rel=1e-3)


@pytest.mark.parametrize("far", [1.0, 10.0])
def test_a_loop_that_rests_says_nothing_of_one_that_moves(far: float) -> None:
    """A constant goes through a slow filter into the gain: its least margin is 50 / w later, or it moves too fast."""
    graph = chain(0.5)
    slow = DiscreteTransferFunction(numerator=(1e-3,), denominator=(1.0, -0.999))
    blocks = {**graph.blocks, "far": Constant(value=0.0), "slow": slow, "one": Constant(value=0.4), "sum": Sum()}
    wires = [*map(str, graph.wires), "far.output -> slow.input", "slow.output -> sum.first"]
    wires += ["one.output -> sum.second", "sum.output -> gain.gain"]
    planned = plan(Graph(name="", rate="1 kHz", duration="1 s", blocks=blocks, wires=wires, loops=graph.loops))
    moving = varied(planned, changed_blocks(planned.blocks, {"far.value": far}))
    (values,) = ManyMargins(planned, "10 ms").values([moving])
    assert isinstance(values, proofmass.ModelError) == (far > 5.0)
    if not isinstance(values, proofmass.ModelError):
        gain = 0.4 + far * (1.0 - 0.999**131)
        assert values[0] == pytest.approx(-20.0 * math.log10(gain), abs=0.05)


def test_threads_share_what_follows_the_time_alone() -> None:
    """x[n + 1] = x[n] - g x[n], where a step adds to g after 5 s: each sensor looks at 10,000 ticks of it."""
    graph = Graph(
        name="slow",
        rate="1 kHz",
        blocks={
            **{"error": Negation(), "gain": Gain(), "sum": Sum(), "delay": UnitDelay(), "level": Sum()},
            **{"step": Step(amplitude=1e-3, start_time=5.0), "one": Constant(value=1e-3)},
        },
        wires=[
            *("delay.output -> error.input", "error.output -> gain.input", "gain.output -> sum.first"),
            *("delay.output -> sum.second", "sum.output -> delay.input", "level.output -> gain.gain"),
            *("step.output -> level.first", "one.output -> level.second"),
        ],
        loops={"main": {"open_at": "gain.output"}},
    )
    planned = plan(graph)
    sensors = [varied(planned, changed_blocks(planned.blocks, {"error.unit": "1"})) for _ in range(6)]
    alone = [margins_alone(sensor, "0 s") for sensor in sensors]
    for _ in range(2):
        shared = Course(planned)
        with ThreadPoolExecutor(6) as pool:
            assert list(pool.map(lambda sensor, like=shared: margins_alone(sensor, "0 s", like), sensors)) == alone


@pytest.mark.parametrize("number", chosen([13], [n for n in range(20) if n != 13]))
def test_random_loops_of_a_spread_gain(number: int) -> None:
    graph, _ = sampled_loop(number)
    planned, sensors = lot(graph, {"gain.gain": 0.3}, 4)
    for sensor, values in zip(sensors, ManyMargins(planned, "0 s").values(sensors), strict=True):
        alone = margins_alone(sensor, "0 s")
        if isinstance(alone, proofmass.ModelError):
            assert isinstance(values, proofmass.ModelError)
        else:
            assert values == pytest.approx(alone, rel=1e-8, nan_ok=True)
