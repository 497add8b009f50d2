"""Carriers whose first samples do the same to small signals, though later ones do not.

A sine of eight samples a turn has two of one size next to each other where its peak, or its zero, lies halfway.
"""

import math

import pytest

from proofmass import Graph, margins, noise, response
from proofmass.blocks import AnalogToDigital, Difference, DiscreteIntegrator, Product, Sine, WhiteNoise

RATE = 80_000
WHITE = WhiteNoise(density=math.sqrt(2.0 / RATE))  # of variance one


def modulated(phase: float) -> Graph:
    """A signal times a sine, twice: its gain is the square of the sine."""
    blocks = {"x": WHITE, "carrier": Sine(frequency=RATE / 8, phase=phase), "up": Product(), "down": Product()}
    wires = [
        "x.output -> up.first", "carrier.output -> up.second", "up.output -> down.first",
        "carrier.output -> down.second",
    ]  # fmt: skip
    return Graph(name="modulated", rate=RATE, blocks=blocks, wires=wires, samples=64)


def closed(phase: float, gain: float) -> Graph:
    """An integrator of the same, fed back: y[n + 1] = (1 - gain sin^2) y[n]."""
    graph = modulated(phase)
    blocks = dict(graph.blocks) | {
        "error": Difference(),
        "sum": DiscreteIntegrator(gain=gain * RATE, output_unit="1"),
    }
    wires = [str(wire) for wire in graph.wires if wire.source != "x.output"]
    wires += [
        "x.output -> error.first", "sum.output -> error.second", "error.output -> up.first",
        "down.output -> sum.input",
    ]  # fmt: skip
    loops = {"main": {"open_at": "sum.output"}}
    return Graph(name="closed", rate=RATE, blocks=blocks, wires=wires, samples=64, loops=loops)


@pytest.mark.exhaustive(but=1)
@pytest.mark.defect("S793", before="0.147, the gain of the first two samples", after="the mean of all of them")
@pytest.mark.parametrize("degrees", [-112.5, -67.5, -22.5, 22.5, 10.0])
def test_the_gain_of_a_square_is_its_mean(degrees: float) -> None:
    """Mean of sin^2 is 1/2, of sin^4 3/8."""
    graph = modulated(math.radians(degrees))
    assert abs(response(graph, "x.output", "down.output", frequencies=[10.0]).gain[0]) == pytest.approx(0.5)
    assert noise(graph, "down.output").rms == pytest.approx(math.sqrt(3.0 / 8.0))


@pytest.mark.exhaustive(but=1)
@pytest.mark.defect("S793", before="gain margin 54.7 dB, of the first two samples", after="of a turn, 50.1 dB")
@pytest.mark.parametrize("degrees", [-112.5, -67.5, -22.5])
def test_margins_of_samples_alike_are_those_of_a_turn(degrees: float) -> None:
    """(1 - f gain p)(1 - f gain q), p = sin^2 22.5 deg, q = 1 - p: beyond f gain = 1 / (p q) it is larger than 1."""
    gain, p = 0.025, math.sin(math.radians(22.5)) ** 2
    found = margins(closed(math.radians(degrees), gain))
    assert found.least_gain_margin == pytest.approx(20.0 * math.log10(1.0 / (p * (1.0 - p)) / gain), rel=1e-9)


@pytest.mark.defect("S794", before="rms 2.0: the first three samples are 2 steps", after="of a turn, 1.73")
def test_a_carrier_in_coarse_steps() -> None:
    """Steps of 1 V: a sine of 2.4 V is 0, 2, 2, 2 and so on, whose squares have the mean 3."""
    blocks = {
        "x": WHITE,
        "carrier": Sine(frequency=RATE / 8, amplitude=2.4, unit="V"),
        "adc": AnalogToDigital(bits=3, reference=4.0),
        "turned": Product(),
    }
    wires = ["carrier.output -> adc.voltage", "x.output -> turned.first", "adc.number -> turned.second"]
    graph = Graph(name="coarse", rate=RATE, blocks=blocks, wires=wires, samples=64)
    assert noise(graph, "turned.output").rms == pytest.approx(math.sqrt(3.0))
