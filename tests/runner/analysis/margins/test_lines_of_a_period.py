"""Frequencies of loops whose period is long: what a period leaves open but for whole turns is what the wire shows."""

import functools
import math

import control
import numpy as np
import pytest

from proofmass.blocks import DiscreteIntegrator, Gain, Negation, Product, RepeatingSequence, Sum
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.analysis.margins.text import margins_text
from tests.by_hand.resting_loops import QUADRATIC
from tests.runner.analysis.margins.test_margins import FAST, lifted

RATE = 80_000.0
PROPORTIONAL, INTEGRAL = 3_300.0, 4.9e6  # 1/s and 1/s^2
CARRIERS = {8: 10_000.0, 800: 9_700.0}  # Hz, by the values of a period


def tracking(values: int) -> Graph:
    """Return a loop of two integrators whose error is multiplied by twice the square of a carrier."""
    ticks = np.arange(values)
    squares = 2.0 * np.sin(2.0 * math.pi * CARRIERS[values] / RATE * ticks) ** 2
    blocks = {
        "carrier": RepeatingSequence(values=tuple(squares.tolist())),
        "minus": Negation(),
        "error": Product(),
        "proportional": Gain(gain=PROPORTIONAL),
        "speed": DiscreteIntegrator(gain=INTEGRAL, output_unit="1"),
        "sum": Sum(),
        "angle": DiscreteIntegrator(output_unit="1"),
    }
    wires = [
        "angle.output -> minus.input",
        "minus.output -> error.first",
        "carrier.output -> error.second",
        "error.output -> proportional.input",
        "error.output -> speed.input",
        "proportional.output -> sum.first",
        "speed.output -> sum.second",
        "sum.output -> angle.input",
    ]
    return Graph(name="tracking", rate=RATE, blocks=blocks, wires=wires, loops={"main": {"open_at": "angle.output"}})


def slowest(found: Margins) -> tuple[float, float]:
    """Return frequency in Hz and damping of the slowest pair, as the text says them."""
    told = next(line for line in margins_text(found).splitlines() if "slowest" in line)
    words = told.replace(",", "").split()
    return float(words[words.index("Hz") - 1]), float(words[words.index("damping") + 1])


@pytest.mark.exhaustive("800")
@pytest.mark.defect("S782", before="a pair at 242 Hz told as 42 Hz, with damping 0.99 for 0.74", after="as it moves")
@pytest.mark.parametrize("values", [8, 800])
def test_the_slowest_pair_is_that_of_the_mean_loop(values: int) -> None:
    """The carrier is far above the loop: its mean, 1, closes z^2 - (2 - p T) z + 1 - p T + i T^2 but for a percent."""
    p, i = PROPORTIONAL / RATE, INTEGRAL / RATE**2
    root = np.roots([1.0, p - 2.0, 1.0 - p + i])[0]
    log = np.log(root.astype(complex)) * RATE
    frequency, damping = slowest(margins(tracking(values)))
    assert frequency == pytest.approx(abs(log.imag) / (2.0 * math.pi), rel=0.02)
    assert damping == pytest.approx(-log.real / abs(log), rel=0.01)


@pytest.mark.exhaustive("800")
@pytest.mark.defect("S783", before="pairs of crossovers at multiples of 1 / T, made by rounding", after="one crossover")
@pytest.mark.parametrize("values", [8, 800])
def test_rounding_makes_no_crossovers(values: int) -> None:
    """L = T (p + i T / (z - 1)) / (z - 1) at the own frequency: nothing turns a line into one that the loop adds up."""
    found = margins(tracking(values))
    loop = control.tf([PROPORTIONAL / RATE], [1.0, -1.0], 1.0 / RATE) + control.tf(
        [INTEGRAL / RATE**2], np.polymul([1.0, -1.0], [1.0, -1.0]), 1.0 / RATE
    )
    *_, crossover = control.margin(loop)
    assert found.gain_crossovers == pytest.approx([crossover / (2.0 * math.pi)], rel=1e-6)
    assert found.phase_crossovers == pytest.approx([0.5 * RATE])


@functools.cache
def without_register() -> Margins:
    return margins(lifted(1, 0.9))


@pytest.mark.exhaustive("100", "150")
@pytest.mark.defect("S784", before="peaks above half the rate of periods told below", after="as without it")
@pytest.mark.parametrize("ratio", [7, 64, 100, 150])
def test_a_register_beside_the_loop_moves_no_frequency(ratio: int) -> None:
    """A period of 64 ticks tells frequencies but for multiples of 156 Hz; the peak is at 83 Hz."""
    plain, found = without_register(), margins(lifted(ratio, 0.9))
    assert (plain.system.per_period, found.system.per_period) == (1, ratio)
    assert plain.sensitivity_peak_frequency is not None
    assert plain.sensitivity_peak_frequency > 0.5 * FAST / 64
    assert found.sensitivity_peak == pytest.approx(plain.sensitivity_peak, rel=1e-6)
    assert found.disk_margin == pytest.approx(plain.disk_margin, rel=1e-6)
    assert found.sensitivity_peak_frequency == pytest.approx(plain.sensitivity_peak_frequency, rel=1e-4)
    assert slowest(found) == pytest.approx(slowest(plain), rel=1e-3)


@pytest.mark.defect("S820", before="ended with a math domain error", after="says that the mode is gone after a period")
def test_a_mode_that_is_gone_after_a_period_has_no_line() -> None:
    """At the start the slope is 1 - g T = 0, and a slower block makes it two values in a period."""
    text = QUADRATIC.replace("gain = 100.0", "gain = 1000.0") + '[blocks.slow]\nkind = "Gain"\nrate = "500 Hz"\n'
    wires = '"level.output -> slow.input", "slow.output -> error.first"'
    graph = read_graph_text(text.replace('"level.output -> error.first"', wires))
    assert "gone after a period" in margins_text(margins(graph))
