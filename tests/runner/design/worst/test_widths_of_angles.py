"""Tolerances and rates of change in units that are plain numbers: of angles and ratios, not parts of a value."""

import math

import pytest

from proofmass import Graph, worst
from proofmass.blocks import Gain, Sine
from proofmass.runner.design.proof.constants_and_rates import change_rates
from proofmass.runner.design.worst.ranges import Range

GRAPH = Graph(
    name="",
    rate=1000,
    samples=2,
    blocks={
        "wave": Sine(phase=math.radians(10.0), unit="V"),
        "gain": Gain(gain=0.1, input_unit="V", output_unit="V"),
    },
    wires=["wave.output -> gain.input"],
    measures={"last": {"signal": "gain.output", "statistic": "last"}},
)


@pytest.mark.defect(
    "S1088", before="`phase=5 deg` of 10 deg was 8.7 % of it, 9.13 to 10.87 deg, also in proofs", after="5 to 15 deg"
)
@pytest.mark.parametrize(
    ("parameter", "tolerance", "ends"),
    [
        ("wave.phase", "5 deg", (math.radians(5.0), math.radians(15.0))),
        ("wave.phase", "20 mrad", (math.radians(10.0) - 0.02, math.radians(10.0) + 0.02)),
        ("wave.phase", "10 %", (math.radians(9.0), math.radians(11.0))),
        ("wave.phase", "0.1", (math.radians(9.0), math.radians(11.0))),
        ("gain.gain", "0.05 V/V", (0.05, 0.15)),
        ("gain.gain", "100 ppm", (0.09999, 0.10001)),
    ],
)
def test_a_width_has_a_unit(parameter: str, tolerance: str, ends: tuple[float, float]) -> None:
    found = worst(GRAPH, {"last": {"measure": "last"}}, tolerances={parameter: tolerance}, samples=1)
    assert (found.ranges[0].low, found.ranges[0].high) == pytest.approx(ends)


@pytest.mark.defect("S1089", before="`1 deg/s` of a phase of 10 deg was 0.17 deg in a second", after="1 deg")
def test_a_rate_of_change_has_a_unit() -> None:
    phase = Range("wave.phase", "wave.phase", "rad", math.radians(10.0), 0.1, 0.2)
    expected = {"1 deg/s": 1.0, "10 %/s": 1.0, "60 deg/min": 1.0, "0.1 1/s": 1.0}
    for text, degrees in expected.items():
        assert change_rates(text, [phase]) == (pytest.approx(math.radians(degrees)),)
