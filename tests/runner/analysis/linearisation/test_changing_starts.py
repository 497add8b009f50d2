"""Loops that change after tick 0, of which the run tells whether they are stable."""

import numpy as np
import pytest

from proofmass import Graph, ModelError, margins, simulate
from proofmass.blocks import (
    Constant,
    Decimator,
    Difference,
    DiscreteIntegrator,
    LowPass,
    MovingAverage,
    Product,
    RepeatingSequence,
    Sine,
    UnitDelay,
)


@pytest.mark.exhaustive
@pytest.mark.defect("S795", before="stable, 22 dB: a zero of the carrier was 1e-16 a turn later", after="unstable")
def test_a_carrier_that_is_zero_at_the_start_of_a_period() -> None:
    """The loop has one period for three of its carrier's eight samples: it repeats after 24, and grows."""
    blocks = {
        "rest": Constant(value=0.0),
        "error": Difference(),
        "carrier": Sine(frequency=10_000.0),
        "mixed": Product(),
        "late": UnitDelay(),
        "filter": LowPass(corner_frequency=20_000.0),
        "mean": Decimator(ratio=3),
        "sum": DiscreteIntegrator(gain=3_000.0, initial=1.0, output_unit="1"),
    }
    wires = [
        "rest.output -> error.first", "sum.output -> error.second", "error.output -> mixed.first",
        "carrier.output -> mixed.second", "mixed.output -> late.input", "late.output -> filter.input",
        "filter.output -> mean.input", "mean.mean -> sum.input",
    ]  # fmt: skip
    graph = Graph(
        name="turning",
        rate=80_000,
        blocks=blocks,
        wires=wires,
        samples=24_000,
        probes=["sum.output"],
        loops={"main": {"open_at": "sum.output"}},
    )
    sizes = np.abs(np.asarray(simulate(graph)["sum.output"]).ravel())
    assert np.max(sizes[-1000:]) > 2.0 * np.max(sizes[-5000:-4000])
    assert margins(graph).verdict == "unstable"


@pytest.mark.defect("S796", before="stable, 26 dB, of a start-up whose run diverges", after="the run, which fails")
def test_a_loop_whose_gain_climbs_until_its_run_fails() -> None:
    """y[n + 1] = (1 - gain) y[n], with a gain of 0.1 at first, and 0.1 more in each tick."""
    blocks = {
        "rest": Constant(value=0.0),
        "one": Constant(value=1.0),
        "ramp": DiscreteIntegrator(gain=100.0, initial=0.1, output_unit="1"),
        "error": Difference(),
        "mixed": Product(),
        "sum": DiscreteIntegrator(gain=1000.0, initial=1e-3, output_unit="1"),
    }
    wires = [
        "one.output -> ramp.input", "rest.output -> error.first", "sum.output -> error.second",
        "error.output -> mixed.first", "ramp.output -> mixed.second", "mixed.output -> sum.input",
    ]  # fmt: skip
    graph = Graph(
        name="ramp", rate=1000, blocks=blocks, wires=wires, samples=400, loops={"main": {"open_at": "sum.output"}}
    )
    with pytest.raises(ModelError, match="is not finite in tick"):
        margins(graph)
    assert margins(graph, at="0 s").stable


@pytest.mark.defect("S797", before="marginal: a running sum has an integrator that nothing reaches", after="stable")
def test_a_running_sum_in_a_loop_with_several_values() -> None:
    """The sum of the last four values is that of its memory: to differ from it is a mode that no gain moves."""
    blocks = {
        "rest": Constant(value=0.0),
        "error": Difference(),
        "average": MovingAverage(length=4),
        "late": UnitDelay(),
        "pattern": RepeatingSequence(values=(0.25, 1.0, 0.25)),
        "mixed": Product(),
        "mean": Decimator(ratio=3),
        "sum": DiscreteIntegrator(gain=300.0, initial=1.0, output_unit="1"),
    }
    wires = [
        "rest.output -> error.first", "sum.output -> error.second", "error.output -> average.input",
        "average.mean -> late.input", "late.output -> mixed.first", "pattern.output -> mixed.second",
        "mixed.output -> mean.input", "mean.mean -> sum.input",
    ]  # fmt: skip
    graph = Graph(
        name="averaged",
        rate=80_000,
        blocks=blocks,
        wires=wires,
        samples=6_000,
        probes=["sum.output"],
        loops={"main": {"open_at": "sum.output"}},
    )
    sizes = np.abs(np.asarray(simulate(graph)["sum.output"]).ravel())
    assert np.max(sizes[-100:]) < 0.1 * np.max(sizes[:100])
    found = margins(graph)
    assert found.stable
    assert ["average" in mode.blocks for mode in found.hidden] == [True]
