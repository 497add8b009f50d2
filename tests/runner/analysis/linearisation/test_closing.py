"""Loops that are closed for an instant by a calibration, and open between: their period is that of the calibrations."""

import math

import numpy as np
import pytest

import proofmass
from proofmass.blocks import (
    CompensationRegister,
    Constant,
    Difference,
    GatedAverage,
    MeasurementSlots,
    Product,
    Sine,
    Sum,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps
from tests.by_hand.amounts import chosen


def calibrated(averaging: int, factor: float = 1.0) -> Graph:
    """A gain of 1.05 that a mean over some ticks corrects, while a vibration that fits no period is there too."""
    blocks: dict[str, Block] = {
        "one": Constant(value=1.0),
        "gain": Constant(value=1.05),
        "vibration": Sine(amplitude=0.01, frequency=math.pi),
        "input": Sum(),
        "scaled": Product(),
        "register": CompensationRegister(limit=0.2),
        "corrected": Product(),
        "slots": MeasurementSlots(slots=1, settling=0.0, averaging=averaging / 100.0),
        "average": GatedAverage(),
        "deviation": Difference(),
        "extra": Constant(value=factor),
        "step": Product(),
    }
    wires = ["one.output -> input.first", "vibration.output -> input.second", "input.output -> scaled.first"]
    wires += ["gain.output -> scaled.second", "scaled.output -> corrected.first", "register.value -> corrected.second"]
    wires += ["corrected.output -> average.input", "slots.measure -> average.measure"]
    wires += ["average.mean -> deviation.first", "one.output -> deviation.second", "deviation.output -> step.first"]
    wires += ["extra.output -> step.second", "step.output -> register.deviation", "slots.finished -> register.load"]
    return Graph(
        name="calibrated", rate="100 Hz", duration="60 s", blocks=blocks, wires=wires, probes=["register.value"]
    )


@pytest.mark.exhaustive
@pytest.mark.parametrize("averaging", chosen((99,), (1000,)))
@pytest.mark.parametrize("factor", [1.0, 0.5])
def test_a_calibration_is_a_loop_from_instant_to_instant(averaging: int, factor: float) -> None:
    """Each corrects a part k of the deviation, L = k / (z - 1): 2 / k reaches -1 at half the rate, and |L| = 1 where
    2 sin(w / 2) = k, with a phase of 90 deg - w / 2 left."""
    found = proofmass.margins(calibrated(averaging, factor), "step.output")
    assert found.stable
    assert found.gain_margin == pytest.approx(2.0 / factor, rel=2e-3)
    assert found.phase_margin == pytest.approx(math.pi / 2.0 - math.asin(0.5 * factor), rel=2e-3)
    assert found.period == pytest.approx((averaging + 1) / 100.0)
    assert any("closed for an instant" in note for note in found.system.map.notes)


@pytest.mark.exhaustive("end of the run")
@pytest.mark.parametrize(("at", "told"), [("0 s", ""), ("auto", "the end of the run, 60.01 s")])
def test_a_loop_that_is_open_at_the_start_is_taken_where_the_run_has_got_to(at: str, told: str) -> None:
    """From the start on it is looked for where it closes if that time is asked for."""
    found = proofmass.margins(calibrated(29), "step.output", at=at)
    assert found.system.map.told == told
    assert found.gain_margin == pytest.approx(2.0, rel=2e-3)
    assert found.phase_margin == pytest.approx(math.pi / 3.0, rel=2e-3)


@pytest.mark.exhaustive
def test_a_register_is_a_wire_with_one_value_a_calibration() -> None:
    found = proofmass.margins(calibrated(300), "register.value")
    assert found.system.per_period == 1
    assert found.gain_margin == pytest.approx(2.0, rel=2e-3)


def test_the_run_of_a_calibration_says_the_same() -> None:
    """1.96 times the correction rings and decays, 2.04 times it rings without end."""
    errors = []
    for factor in (1.96, 2.04):
        values = np.array(proofmass.simulate(calibrated(99, factor), duration="40 s")["register.value"].values)
        jumps = np.abs(np.diff(values))[np.flatnonzero(np.diff(values))]
        errors.append((float(np.median(jumps[:6])), float(np.median(jumps[-6:]))))
    assert errors[0][1] < 0.6 * errors[0][0]
    assert errors[1][1] > 1.3 * errors[1][0]


@pytest.mark.parametrize("first", [0, 2])
def test_held_values_count_once(first: int) -> None:
    """Two values of the wire, held for 3 ticks each: the closed loop has the same poles, by one value a hold."""
    random = np.random.default_rng(4)
    n, ticks, held = 3, 6, 3
    a, b = np.tile(np.eye(n), (ticks, 1, 1)), np.zeros((ticks, n))
    for k in range(ticks):
        a[k, 1:] = random.normal(size=(2, n)) * 0.4
        b[k, 1:] = random.normal(size=2)
        if (k - first) % held == held - 1:
            a[k, 0], b[k, 0] = random.normal(size=n) * 0.4, random.normal()
    c = np.tile([1.0, 0.0, 0.0], (ticks, 1))
    maps = TickMaps(a, b, c, np.zeros(ticks), {("x", "", i): i for i in range(n)})
    assert maps.holds() == (first, held)
    if first == 0:
        states = list(maps.places)
        assert np.allclose(maps.held(held).closed(states, -0.7), maps.closed(states, -0.7), rtol=1e-12)


def test_other_values_are_not_held() -> None:
    a = np.array([np.diag([1.0, 0.5]), np.diag([1.0, 0.5]), np.diag([0.9, 0.5])])
    maps = TickMaps(a, np.ones((3, 2)), np.tile([1.0, 0.0], (3, 1)), np.zeros(3), {("x", "", 0): 0, ("x", "", 1): 1})
    assert maps.holds() == (0, 1)
