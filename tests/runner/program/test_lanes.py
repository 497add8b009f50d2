"""Runs side by side in lanes against each run alone: every state, to the bit."""

import dataclasses
import math
import random
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import proofmass
from proofmass import Block, Graph, param
from proofmass.blocks import DiscreteIntegrator, Ramp, UnitDelay
from proofmass.blocks.declaration.declare import Recording
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.plan.keys import StateField, WireOf
from proofmass.runner.plan.measuring import value_of
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.run.side_by_side import SideBySide
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes
from tests.by_hand.graph_texts import LIBRARY
from tests.by_hand.lanes_alone import assert_lanes_are_runs

LANES, RUNS, TICKS = 4, 7, 700
# A linear group with measures, Runge-Kutta, noise with integer code, correlation cells, a recording:
GRAPHS = (
    "scale_factor_drift",
    "vibratory_gyroscope",
    "temperature_compensation_m1",
    "pn_self_test_minimal",
    "recorded_motion",
)


def changed(planned: Plan, draw: random.Random) -> dict[tuple[str, str], float]:
    """A small change of every number of a plan that neither a wire nor a format settles."""
    found = {}
    for name, block in planned.blocks.items():
        for parameter, declared in type(block).parameters.items():
            if (
                declared.kind is float
                and not type(block).has_formats()
                and (name, parameter) not in planned.schedule.drivers
            ):
                found[name, parameter] = getattr(block, parameter) * (1.0 + 1e-4 * draw.uniform(-1.0, 1.0))
    return found


def sensors(planned: Plan, draw: random.Random) -> tuple[list[Plan], list[dict[tuple[str, str], float]]]:
    """Some plans that differ in their numbers, and the numbers."""
    plans: list[Plan] = []
    given: list[dict[tuple[str, str], float]] = []
    while len(plans) < RUNS:
        values = changed(planned, draw)
        blocks: dict[str, Any] = {}
        try:
            for name in {name for name, _ in values}:
                block = planned.blocks[name]
                now = {p: values.get((name, p), getattr(block, p)) for p in type(block).parameters}
                blocks[name] = type(block)(**now)
            plans.append(varied(planned, blocks))
        except ModelError:  # two of its numbers must be alike
            continue
        given.append(values)
    return plans, given


@pytest.mark.exhaustive("temperature_compensation_m1", "recorded_motion", "scale_factor_drift", "pn_self_test_minimal")
@pytest.mark.parametrize("name", GRAPHS)
def test_of_the_library(name: str) -> None:
    path = next(path for path in LIBRARY if path.stem == name)
    planned = plan(dataclasses.replace(read_graph(path), probes=()))
    plans, values = sensors(planned, random.Random(name))
    given = {node: np.array([each[node] for each in values]) for node in values[0]}
    lanes = Lanes(CompiledLanes(planned, set(given), LANES), 7, range(RUNS), given, plans)
    for until in (1, TICKS // 2, TICKS):  # in chunks of any length
        lanes.advance(until)
    one = CompiledPlan(planned)
    different = set()
    for number, alone in enumerate(plans):
        loop = CompiledLoop(alone, 7, number, start(alone), one)
        assert lanes.sound()[number] == loop.advance(TICKS, ())
        memory, found = loop.memory(), dict[tuple[str, ...], Any]()
        for name, state in memory.states.items():
            for field in () if state is None else state._fields:
                found[name, "x", field] = lanes.value(StateField(name, field))[number].item()
                assert repr(found[name, "x", field]) == repr(getattr(state, field)), (name, field)
        for measure in (each for each in planned.measures if each.first < TICKS):
            assert lanes.value(WireOf(*measure.node))[number] == value_of(alone, measure, memory), measure.name
        different.add(repr(found))
    assert len(different) == RUNS


def held() -> Graph:
    """A number that stays what it begins as, and its sum."""
    wires = ["delay.output -> delay.input", "delay.output -> sum.input"]
    return Graph(name="", rate="1 kHz", blocks={"delay": UnitDelay(), "sum": DiscreteIntegrator()}, wires=wires)


def test_runs_that_differ_in_how_they_begin_alone() -> None:
    planned = plan(held(), free=["delay.initial"])
    begins = [0.0, 1.0, -2.5, 1e9]
    plans = [varied(planned, {"delay": UnitDelay(initial=begin)}) for begin in begins]
    assert_lanes_are_runs(planned, {("delay", "initial"): np.array(begins)}, plans, "sum")


class Played(Block):
    """Half of a number times a recording, added up from that number on."""

    file: str = param("", "A file of times and values.", default="")
    column: str = param("", "Its column.", default="")
    begin: float = param("1", "The sum at the start.", default=0.0)
    values = Recording("value", "Recorded values.")


class Half(NamedTuple):
    half: float


class Sum(NamedTuple):
    total: float


@Played.constants
def halved(p: Played, period: float) -> Half:
    return Half(0.5 * p.begin)


@Played.start
def begins(p: Played) -> Sum:
    return Sum(p.begin)


@Played.output("1")
def total(c: Half, x: Sum) -> float:
    """The sum so far."""
    return x.total


@Played.update
def add(c: Half, x: Sum, tick: int, values: list[float]) -> Sum:
    return Sum(x.total + c.half * values[tick % len(values)])


def test_runs_share_the_recording_of_a_block_in_which_they_differ(tmp_path: Path) -> None:
    (tmp_path / "played.csv").write_text("time [s],value\n0,0.1\n1,-0.7\n2,1.3\n")
    block = Played(file=str(tmp_path / "played.csv"))
    planned = plan(Graph(name="", rate="1 Hz", blocks={"played": block}), free=["played.begin"])
    sums = [0.0, 1.0, -2.5, 1e9]
    plans = [varied(planned, {"played": dataclasses.replace(block, begin=begin)}) for begin in sums]
    assert_lanes_are_runs(planned, {("played", "begin"): np.array(sums)}, plans, "played")


def test_runs_go_in_as_few_groups_as_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = CompiledLanes(plan(held()), (), 4)
    calls = list[Any]()
    monkeypatch.setattr(compiled, "loop", lambda *given: calls.append(given))
    Lanes(compiled, 0, range(7), {}).advance(8)
    assert len(calls) == 2


@proofmass.block("1", base="1", exponent=param("1", "Exponent.", default=2.0))
def power(p: Any, base: float) -> float:
    """Power of the input, by the C library."""
    return base**p.exponent + 2.0**base


def test_powers_of_other_exponents_side_by_side() -> None:
    blocks = {"ramp": Ramp(slope=300.0, offset=0.5), "power": power()}
    graph = Graph(name="powers", rate="1 kHz", blocks=blocks, wires=["ramp.output -> power.base"])
    exponents, node = [0.5, -1.25, 3.0, math.pi], ("power", "exponent")
    planned = plan(graph)
    lanes = Lanes(CompiledLanes(planned, frozenset({node}), LANES), 0, range(LANES), {node: np.array(exponents)})
    lanes.advance(8)
    base = 0.5 + 0.3 * 7
    expected = [base**exponent + 2.0**base for exponent in exponents]
    np.testing.assert_allclose(lanes.value(WireOf("power", "power")), expected, rtol=1e-14)
    none = SideBySide(planned, 0, 8, LANES, ["power.exponent"])
    measured, valid = none.measured({"power.exponent": np.array([math.nan, math.inf])}, np.arange(2))
    assert (measured.shape, valid.tolist()) == ((2, 0), [False, False])
