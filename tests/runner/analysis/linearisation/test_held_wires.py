"""Wires that hold what slower blocks said, also before a period begins, by a clock offset."""

import cmath
import math

import pytest

from proofmass import Graph, noise, response
from proofmass.blocks import Constant, Gain
from proofmass.graphs.files.toml_reader import read_graph_text

# A block at 100 Hz speaks 5 ms late: as the second period begins, its wire still holds the zero of the first one.
# It reads 3, and the square of that has the slope 6.
HELD = read_graph_text("""
name = "held"
rate = "1 kHz"
wires = [
    "source.output -> sum.first", "noise.output -> sum.second", "sum.output -> hold.input",
    "hold.output -> square.input",
]

[blocks]
source = { kind = "Constant", value = 3.0 }
noise = { kind = "WhiteNoise", density = 0.001 }
sum = { kind = "Sum" }
hold = { kind = "UnitDelay", rate = "100 Hz", clock_offset = "5 ms" }
square = { kind = "Power", exponent = 2.0 }
""")


@pytest.mark.defect("S861", before="3, the mean of 0 and 6", after="6")
def test_a_response_waits_until_what_is_held_has_come() -> None:
    assert response(HELD, "source.output", "square.output").at_rest == pytest.approx(6.0, rel=1e-12)


@pytest.mark.defect("S861", before="0.0949, of slopes 0 and 6", after="0.1342")
def test_noise_waits_until_what_is_held_has_come() -> None:
    """Noise of 0.001 / sqrt(Hz) at 1 kHz has an rms of 0.001 sqrt(500), of which every tenth value is held."""
    assert noise(HELD, "square.output").rms == pytest.approx(6.0 * 0.001 * math.sqrt(500.0), rel=1e-12)


@pytest.mark.defect("S866", before="0.4 at rest: of longer periods later ticks did not count", after="1")
def test_a_slow_input_holds_from_tick_to_tick() -> None:
    """Values of 200 Hz are read at 300 Hz, and these at 500 Hz; 90 base ticks are a period."""
    graph = Graph(
        name="three rates",
        rate="9 kHz",
        blocks={"source": Constant(), "first": Gain(), "second": Gain(), "fast": Constant()},
        wires=["source.output -> first.input", "first.output -> second.input"],
        rates={"source": "200 Hz", "first": "300 Hz", "second": "500 Hz"},
    )
    found = response(graph, "source.output", "second.output", frequencies=[30.0])
    late = (0.0, 2e-3, 4e-3, 6e-3, 3e-3)  # s since the source spoke, of the values at 0, 2, 4, 6 and 8 ms
    assert found.at_rest == pytest.approx(1.0, rel=1e-12)
    assert found.gain[0] == pytest.approx(sum(cmath.exp(-60j * math.pi * t) for t in late) / 5.0, rel=1e-12)
