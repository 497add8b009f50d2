"""Loops of the library at tolerances of their studies: proofs, their certificates, and sensors within."""

import math
import random
from typing import Any

import pytest

from proofmass import margins, prove, read_graph, read_study
from proofmass.runner.design.proof.prove import Proofs
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import check_certificate
from tests.runner.design.proof.test_prove import status


def no_sensor_has_less(found: Proofs, loop: str, decibels: float, degrees: float) -> None:
    """The claims are proved; so says the checker, and so do ten sensors at corners or anywhere."""
    assert status(found) == ["proved"] * 3
    assert len(check_certificate(certificate(found))) == 3
    draw = random.Random(8)
    for number in range(10):
        values = {one.written: draw.uniform(one.low, one.high) for one in found.ranges}
        if number < 5:
            values = {one.written: draw.choice([one.low, one.high]) for one in found.ranges}
        figures: Any = margins(found.graph.with_parameters(values), loop, at="0 s")
        assert math.degrees(figures.phase_margin) >= degrees
        assert figures.least_gain_margin >= decibels


@pytest.mark.exhaustive
def test_the_fluxgate_at_the_tolerances_of_its_study() -> None:
    """Cores within 30 and 15 %, whose slope is 1 / cosh^2, and an excitation within 15 %."""
    found = prove(read_study("library:closed_loop_fluxgate"), phase_margin="45 deg", gain_margin="6 dB", seconds=6000)
    assert max(len(one.searched.leaves) for one in found.proofs) < 20
    no_sensor_has_less(found, "field", 6.0, 45.0)


@pytest.mark.exhaustive
def test_the_accelerometer_with_eight_parameters_within_ten_per_cent() -> None:
    """Five of them are gains in a row, with a reference below: the worst that is found has 26.42 dB and 78.5 deg."""
    gains = ["pickoff.gain", "resistor.gain", "torquer.gain", "adc.reference", "reference.offset"]
    within = [*gains, "pendulum.inertia", "pendulum.damping", "pendulum.stiffness"]
    graph = read_graph("library:closed_loop_accelerometer")
    tolerances = dict.fromkeys(within, "10 %")
    found = prove(graph, tolerances=tolerances, gain_margin="26 dB", phase_margin="77 deg", seconds=6000)
    assert max(len(one.searched.leaves) for one in found.proofs) < 200
    no_sensor_has_less(found, "main", 26.0, 77.0)


@pytest.mark.exhaustive
def test_a_part_of_the_tolerances_of_the_seismometer() -> None:
    """A period of 20 ticks of a loop of 10 states, among them a frame with a light mode of 564 Hz."""
    tolerances = {"frame.stiffness": "0.5 %", "frame.damping": "60 %", "pickoff.gain": "15 %"}
    graph = read_graph("library:force_balance_seismometer")
    found = prove(graph, tolerances=tolerances, phase_margin="30 deg", gain_margin="6 dB", seconds=6000)
    no_sensor_has_less(found, "balance", 6.0, 30.0)
