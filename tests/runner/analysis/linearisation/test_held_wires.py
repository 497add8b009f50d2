"""Wires that still hold, as a period begins, what a block with a clock offset said before."""

import math

import pytest

from proofmass import noise, response
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
