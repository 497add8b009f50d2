"""What a proof does not show meets no requirement, wherever its limit lies."""

import math

import pytest

from proofmass import Graph
from proofmass.blocks import Difference, Gain, LowPass, Step
from proofmass.graphs.checks.check import check
from proofmass.runner.verification.verify import Measurements, verify

TOLERANCES = {"back.gain": "120 %"}  # of L = k / (1 + s / w) from k = -4 to 44, which is unstable below -1


def required(**requirement: object) -> Graph:
    """Return the loop with a requirement that is to be proved."""
    return Graph(
        name="loop",
        rate="1 kHz",
        samples=10,
        blocks={"push": Step(), "error": Difference(), "plant": LowPass(corner_frequency=5.0), "back": Gain(gain=20.0)},
        wires=[
            "push.output -> error.first",
            "back.output -> error.second",
            "error.output -> plant.input",
            "plant.output -> back.input",
        ],
        loops={"main": {"open_at": "back.output"}},
        requirements={"R": {"tolerances": TOLERANCES, "proved": True, **requirement}},
    )


@pytest.mark.defect("S1081", before="an unstable sensor had a gain margin of 0 dB: met", after="no value: missed")
@pytest.mark.parametrize("margin", ["gain_margin", "phase_margin"])
def test_an_unstable_sensor_has_no_margin(margin: str) -> None:
    (found,) = verify(Measurements(required(quantity=f"main.{margin}", at_least=0), None, "python"))
    assert not found.met
    assert math.isnan(found.value)
    assert found.reason.startswith("a sensor within the tolerances has unstable")


@pytest.mark.defect("S1082", before="a verdict of 2, which there is not, was met by a proof", after="missed, by a 1")
def test_a_proof_of_stability_has_the_number_of_its_verdict() -> None:
    graph = required(quantity="main.stable", at_least=2, tolerances={"back.gain": "5 %"})
    (found,) = verify(Measurements(graph, None, "python"))
    assert (found.met, found.value) == (False, 1.0)


@pytest.mark.defect("C900", before="ZeroDivisionError of a delay margin of 0 s", after="must be above zero")
@pytest.mark.parametrize(
    ("margin", "limit", "message"),
    [
        ("delay_margin", 0, "must be above zero"),
        ("disk_margin", 0, "must be above zero"),
        ("disk_margin", 2, "must be below 2"),
    ],
)
def test_limits_that_no_proof_takes_are_refused(margin: str, limit: float, message: str) -> None:
    (problem,) = check(required(quantity={"loop": "main", "figure": margin}, at_least=limit))
    assert (problem.message, problem.key) == (message, "requirements.R.at_least")
