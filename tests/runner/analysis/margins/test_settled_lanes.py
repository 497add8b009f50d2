"""Sensors that run to rest side by side: where each is to the bit what it is alone, and which of them run alone."""

from dataclasses import replace

import pytest

import proofmass
from proofmass.blocks import Delay, FractionalDelay, UnitDelay
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.changes import changed_blocks
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.analysis.margins import settled_lanes
from proofmass.runner.analysis.margins.many import ManyMargins, margins_alone
from proofmass.runner.analysis.margins.settled_lanes import SettledLanes
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from tests.by_hand.lagging_loop import lagging

_MANY = 1_000_000  # for which compiling always pays
_GAINS = (0.3, 0.2, 0.25, 0.35, 0.15, 0.1, 0.28, 0.31)


def delayed() -> Graph:
    """A loop that settles, with buffers: what it feeds back is late by 2.4 samples, and by 3 more."""
    graph = lagging()
    wires = [str(wire) for wire in graph.wires if str(wire) != "delay.output -> error.second"]
    wires += ["delay.output -> late.input", "late.output -> later.input", "later.output -> error.second"]
    blocks = {**graph.blocks, "late": FractionalDelay(delay=2.4), "later": Delay(ticks=3), "delay": UnitDelay()}
    return Graph(name="late", rate="1 kHz", duration="1 s", blocks=blocks, wires=wires, loops=graph.loops)


def sensors_of(planned: Plan, values: list[dict[str, float]]) -> list[Plan]:
    return [varied(planned, changed_blocks(planned.blocks, of)) for of in values]


def alone(sensor: Plan) -> Memory:
    course = Course(sensor)
    return course.at(settled_tick(course))


def side_by_side(planned: Plan, sensors: list[Plan], within: int = 2_000) -> list[Memory | None]:
    plans = [Course(sensor).plan for sensor in (planned, *sensors)]
    return SettledLanes(plans[0], within).memories(plans[1:], _MANY)


def test_they_settle_in_the_same_tick_with_the_same_memory_as_alone() -> None:
    """Buffers differ with the delay, which is fixed before a run."""
    planned = plan(delayed())
    sensors = sensors_of(planned, [{"gain.gain": 0.3 * g, "late.delay": 2.1 + g} for g in _GAINS])
    together = side_by_side(planned, sensors)
    assert together == [alone(sensor) for sensor in sensors]
    assert len({memory.tick for memory in together if memory}) > 1, "all settle at once: nothing is compared"


@pytest.mark.exhaustive
def test_sensors_of_a_gyroscope() -> None:
    planned = plan(proofmass.read_graph("library:closed_loop_gyroscope"))
    sensors = sensors_of(planned, [{"drive_pickoff.gain": 5e5 * (0.9 + gain)} for gain in _GAINS])
    together = side_by_side(planned, sensors, 150_000)
    assert [memory and read(memory) for memory in together] == [read(alone(sensor)) for sensor in sensors]


def read(memory: Memory) -> Memory:
    """The memory without the values of measures, which no block reads: one run alone holds none on the way."""
    return replace(memory, wires={node: x for node, x in memory.wires.items() if not node[0].startswith("measures.")})


def test_one_that_does_not_settle_hides_no_other_one() -> None:
    planned = plan(lagging())
    sensors = sensors_of(planned, [{"gain.gain": gain} for gain in (*_GAINS[:-1], 2.5)])
    *others, growing = side_by_side(planned, sensors)
    assert others == [alone(sensor) for sensor in sensors[:-1]]
    assert growing is None
    with pytest.raises(ModelError):
        alone(sensors[-1])


def test_others_than_real_numbers_are_no_case_for_lanes() -> None:
    planned = plan(delayed())
    several = [replace(planned, blocks=planned.blocks | {"later": Delay(ticks=3, unit="m")})] * 8
    assert side_by_side(planned, several) == [None] * 8


def test_figures_are_those_of_the_certified_path(monkeypatch: pytest.MonkeyPatch) -> None:
    planned = plan(lagging())
    sensors = sensors_of(planned, [{"gain.gain": gain} for gain in _GAINS])
    apart = ManyMargins(planned, "settled").values(sensors)  # a few thousand ticks: alone
    monkeypatch.setattr(settled_lanes, "is_short", lambda *_: False)
    assert ManyMargins(planned, "settled").values(sensors) == apart
    for values, sensor in zip(apart[:2], sensors, strict=False):
        assert values == pytest.approx(margins_alone(sensor, "settled"), rel=1e-11)


def test_a_parameter_that_a_wire_gives_does_not_tell_sensors_apart() -> None:
    driven = lagging()
    wires = [*map(str, driven.wires), "one.output -> gain.gain"]
    planned = plan(Graph(name="driven", rate="1 kHz", duration="1 s", blocks=driven.blocks, wires=wires))
    sensors = sensors_of(planned, [{"gain.gain": gain} for gain in _GAINS])
    assert side_by_side(planned, sensors) == [None] * 8, "all are alike: there is nothing to run side by side"
