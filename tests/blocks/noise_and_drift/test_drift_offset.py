"""The constant drift, and the form that all drifts share: they chain, and they drive parameters."""

import pytest

from proofmass.blocks import (
    DriftOffset,
    DriftRamp,
    FlickerNoise,
    Gain,
    GaussMarkov,
    LogarithmicAgeing,
    PeriodicDrift,
    RandomWalk,
    Step,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive
from tests.runner.run.test_engines_agree import assert_same_bits


def test_so_many_parts_per_million_off() -> None:
    row = drive(DriftOffset(offset="200 ppm", nominal="5 V", unit="V"), [{}])[0]
    assert row == {"value": 5.0 * 1.0002, "deviation": 200e-6}


def test_nominal_in_the_unit_of_the_value() -> None:
    assert DriftOffset(nominal="342 ohm", unit="kohm").nominal == 0.342
    with pytest.raises(ModelError, match="in V"):
        DriftOffset(nominal="5 A", unit="V")


def test_a_chain_multiplies_the_factors() -> None:
    graph = Graph(
        name="chain",
        rate=100,
        blocks={
            "tolerance": DriftOffset(offset="-300 ppm", nominal=2.5, unit="V"),
            "warming": DriftRamp(slope="10 ppm/s", unit="V"),
            "room": PeriodicDrift(cycle_time=1.0, unit="V"),
        },
        wires=["tolerance.value -> warming.nominal", "warming.value -> room.nominal"],
        probes=["room.value", "warming.deviation", "room.deviation"],
    )
    result = simulate(graph, samples=300, engine="python")
    deviations = (-300e-6, result["warming.deviation"].values, result["room.deviation"].values)
    product = (1.0 + deviations[0]) * (1.0 + deviations[1]) * (1.0 + deviations[2])
    assert result["room.value"].values == pytest.approx(2.5 * product, rel=1e-15)


KINDS = [DriftOffset, DriftRamp, FlickerNoise, GaussMarkov, LogarithmicAgeing, PeriodicDrift, RandomWalk]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_value_drives_a_parameter_and_is_the_nominal_value_changed_by_the_deviation(kind: type[Block]) -> None:
    graph = Graph(
        name="driven",
        rate=1000,
        blocks={"drift": kind(nominal=3.0), "step": Step(amplitude=2.0), "gain": Gain()},
        wires=["drift.value -> gain.gain", "step.output -> gain.input"],
        probes=["gain.output", "drift.deviation"],
    )
    result = simulate(graph, samples=100, engine="python")
    deviation = result["drift.deviation"].values
    assert result["gain.output"].values == pytest.approx(6.0 * (1.0 + deviation), rel=1e-15)


@pytest.mark.exhaustive
def test_parameters_of_drifts_can_be_driven_themselves() -> None:
    graph = Graph(
        name="driven drifts",
        rate=1000,
        blocks={
            "ramp": DriftRamp(slope=0.3, nominal=0.7),
            "walk": RandomWalk(),
            "markov": GaussMarkov(),
            "flicker": FlickerNoise(),
            "ageing": LogarithmicAgeing(onset=1.0),
            "seconds": DriftRamp(slope=0.3, nominal=0.7, unit="s"),
            "step": DriftRamp(slope=0.2, unit="1/sqrt(s)"),
        },
        wires=[
            "step.value -> walk.coefficient",
            "seconds.value -> markov.correlation_time",
            "ramp.value -> flicker.level",
            "ramp.value -> ageing.nominal",
        ],
        probes=["walk.value", "markov.value", "flicker.value", "ageing.value"],
        seed=3,
    )
    assert_same_bits(graph, 3000)
