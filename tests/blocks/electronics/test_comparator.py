"""The comparator: hysteresis by hand, right in its own tick and at the start, and a modulator of second order."""

import math

import numpy as np
import pytest

from proofmass.blocks import Comparator, Difference, DiscreteIntegrator, Sine
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive


def signs(block: Comparator, inputs: list[float]) -> list[float]:
    rows = drive(block, [{"input": u} for u in inputs])
    assert [row["on"] for row in rows] == [row["sign"] > 0.0 for row in rows]
    return [row["sign"] for row in rows]


@pytest.mark.defect("S9", before="a Relay read at ticks is a tick late", after="a Comparator answers in its tick")
def test_it_answers_in_the_tick_of_the_step() -> None:
    assert signs(Comparator(), [-1.0, -1.0, 1.0, 1.0, -1.0]) == [-1.0, -1.0, 1.0, 1.0, -1.0]


@pytest.mark.defect("S9", before="a Relay always starts off", after="its input decides in tick 0")
def test_its_input_decides_in_the_first_tick() -> None:
    assert signs(Comparator(), [0.7]) == [1.0]
    assert signs(Comparator(initially_on=True), [-0.7]) == [-1.0]


def test_within_the_hysteresis_it_stays_and_starts_as_it_is_told() -> None:
    inputs = [0.9, 1.4, 1.5, 1.2, 0.5, 0.49, 1.49, 1.5]
    expected = [-1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0]
    assert signs(Comparator(threshold=1.0, hysteresis=1.0), inputs) == expected
    assert signs(Comparator(threshold=1.0, hysteresis=1.0, initially_on=True), inputs)[:2] == [1.0, 1.0]


def test_without_hysteresis_the_threshold_itself_is_on_however_it_came() -> None:
    assert signs(Comparator(threshold=2.0), [2.0, 1.0, 2.0, 3.0, 2.0]) == [1.0, -1.0, 1.0, 1.0, 1.0]


def modulator(samples: int, amplitude: float, frequency: float) -> tuple[np.ndarray, np.ndarray]:
    """A sigma-delta modulator of second order with unit delays in both integrators, at 1 Hz; integrators, bits."""
    graph = Graph(
        name="second-order modulator",
        rate=1,
        blocks={
            "input": Sine(amplitude=amplitude, frequency=frequency, phase=0.3),
            "first_sum": Difference(),
            "first": DiscreteIntegrator(gain=0.5, output_unit="1"),
            "second_sum": Difference(),
            "second": DiscreteIntegrator(gain=0.5, output_unit="1"),
            "quantiser": Comparator(),
        },
        wires=[
            "input.output -> first_sum.first",
            "quantiser.sign -> first_sum.second",
            "first_sum.output -> first.input",
            "first.output -> second_sum.first",
            "quantiser.sign -> second_sum.second",
            "second_sum.output -> second.input",
            "second.output -> quantiser.input",
        ],
        probes=["second.output", "quantiser.sign"],
    )
    result = simulate(graph, samples=samples, engine="python")
    return result["second.output"].values, result["quantiser.sign"].values


@pytest.mark.defect(
    "S9", before="a modulator with a Relay swings +-560", after="within +-4, as the difference equations"
)
def test_a_modulator_of_second_order_is_that_of_its_difference_equations() -> None:
    amplitude, frequency = 0.5, 1.0 / 257.0
    second, bits = modulator(4000, amplitude, frequency)
    y1 = y2 = 0.0
    for n in range(4000):
        u = amplitude * math.sin(2.0 * math.pi * frequency * n + 0.3)
        assert abs(second[n] - y2) < 1e-9
        v = 1.0 if y2 >= 0.0 else -1.0
        assert bits[n] == v
        y1, y2 = y1 + 0.5 * (u - v), y2 + 0.5 * (y1 - v)
    assert np.abs(second).max() < 4.0
    assert abs(np.mean(bits[:2570])) < 0.01  # ten periods of the sine


def test_its_threshold_may_be_driven() -> None:
    assert Comparator.drivable("threshold")
    assert not Comparator.drivable("initially_on")
