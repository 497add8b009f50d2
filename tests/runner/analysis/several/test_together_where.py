"""Where loops are perturbed together: about the operating point at which each of them is a loop that stays."""

import math

import numpy as np
import pytest

from proofmass import Graph, margins_together, read_graph
from proofmass.blocks import Comparator, Difference, DiscreteIntegrator, Saturation, Step
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.analysis.several.together import of_system
from proofmass.runner.commands.several_loops import _together_lines
from tests.runner.analysis.several.test_together import system_of


def beside(*gains: float) -> Graph:
    """Integrating loops that begin at the limit of their actuator: L = k / (z - 1) once they have left it."""
    blocks, wires = {}, list[str]()
    for number, gain in enumerate(gains):
        error, limit, held = (f"{name}_{number}" for name in ("error", "limit", "held"))
        blocks |= {
            f"wanted_{number}": Step(amplitude=10.0),
            error: Difference(),
            limit: Saturation(lowest=-1.0, highest=1.0),
            held: DiscreteIntegrator(gain=1000.0 * gain, output_unit="1"),
        }
        wires += [f"wanted_{number}.output -> {error}.first", f"{held}.output -> {error}.second"]
        wires += [f"{error}.output -> {limit}.input", f"{limit}.output -> {held}.input"]
    return Graph(name="", rate=1000, blocks=blocks, wires=wires, duration=1.0)


@pytest.mark.defect(
    "S1068",
    before="a disk margin of 2, and any gain allowed, of loops that were open at the start of their run",
    after="that of the loops once they have closed",
)
def test_loops_that_are_open_at_the_start_are_taken_where_they_close() -> None:
    """|S - 1/2| of k / (z - 1) is largest at half the rate: (2 + k) / (2 - k) / 2."""
    found = margins_together(beside(0.4, 1.0), ["held_0.output", "held_1.output"])
    alone = [2.0 * (2.0 - gain) / (2.0 + gain) for gain in (0.4, 1.0)]
    assert found.verdict == "stable"
    assert found.alone == pytest.approx(alone, rel=1e-6)
    assert found.margin == pytest.approx(min(alone), rel=1e-6)
    assert found.tick > 0
    assert found.told.startswith("settled")
    assert any(line.startswith(f"  linearised at tick {found.tick:,}") for line in _together_lines(found))


def test_a_time_that_is_named_is_where_they_are_taken() -> None:
    """At the start nothing comes back at the wires, and none is stable by that."""
    with pytest.raises(ModelError, match="does not come back"):
        margins_together(beside(0.4, 1.0), ["held_0.output", "held_1.output"], at=0.0)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["open_loop_gyroscope", "closed_loop_gyroscope"])
@pytest.mark.defect("S1069", before="unstable: loops of oscillators that start from rest", after="stable, settled")
def test_loops_that_start_up_are_taken_where_they_have_settled(name: str) -> None:
    """The loops hardly meet: what all leave at once is the least that one leaves alone, by its own margins."""
    graph = read_graph(f"library:{name}")
    found = margins_together(graph)
    alone = [margins(graph, loop).disk_margin for loop in found.loops]
    assert found.verdict == "stable"
    assert found.alone == pytest.approx(alone, rel=0.01)
    assert found.margin == pytest.approx(min(alone), rel=0.01)


@pytest.mark.exhaustive
@pytest.mark.defect("S1070", before="a disk margin of 2 through bits that nothing passes", after="that in a run")
def test_loops_through_one_bit_have_the_gains_of_a_run() -> None:
    graph = read_graph("library:sigma_delta_accelerometer")
    found = margins_together(graph)
    alone = [margins(graph, loop).disk_margin for loop in found.loops]
    assert found.alone == pytest.approx(alone, rel=0.02)
    assert found.margin == pytest.approx(min(alone), rel=0.02)
    assert sum("one bit counts as a gain" in note for note in found.notes) == 2


def test_an_output_that_closes_no_loop_is_named() -> None:
    """What a comparator says of a loop goes nowhere."""
    graph = beside(0.4)
    blocks = {**graph.blocks, "seen": Comparator()}
    whole = Graph(name="", rate=1000, blocks=blocks, wires=[*graph.wires, "held_0.output -> seen.input"], duration=1.0)
    with pytest.raises(ModelError, match=r"seen\.sign does not come back"):
        margins_together(whole, ["held_0.output", "seen.sign"])


@pytest.mark.defect("S1071", before="a factor of 9e15 made loops unstable that nothing comes back to", after="none")
def test_factors_without_limit_are_not_named() -> None:
    a, b = np.diag([0.5, 0.25]), np.eye(2)
    found = of_system(system_of(a, b, np.zeros((2, 2)), np.zeros((2, 2)), 1.0), ["x", "y"], [1, 1])
    assert found.margin == pytest.approx(2.0)
    assert found.gain == math.inf
    assert found.factors == ()
    assert not any("these factors" in line for line in _together_lines(found))


@pytest.mark.defect("H904", before="out of memory: run fewer samples", after="told from the schedule")
def test_too_many_values_are_told_from_the_schedule() -> None:
    with pytest.raises(ModelError, match=r"(?s)too many values.*3,069.*at most 256"):
        margins_together(read_graph("library:imu_3dof"))


@pytest.mark.exhaustive
def test_too_many_values_of_an_orbit_are_told_where_it_is_found() -> None:
    with pytest.raises(ModelError, match=r"(?s)too many values.*32,736"):
        margins_together(read_graph("library:self_calibration_in_operation"))
