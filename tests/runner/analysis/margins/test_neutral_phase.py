"""A drive loop that holds an oscillation: its phase is neutral, and no verdict hangs on the last bit of that."""

import math

import pytest

from proofmass import read_graph
from proofmass.blocks import (
    PID,
    CombDrive,
    Constant,
    Decimator,
    Difference,
    DiscreteIntegrator,
    DisplacementReadout,
    Gain,
    MassSpringDamper,
    Product,
    Sine,
    Sum,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.margins.stability import margins
from tests.by_hand.amounts import chosen

CARRIER, MASS = 8000.0, 50e-9


def drive(stiffness: float) -> Graph:
    """A resonator of Q 8000 at 8 kHz, its frequency and amplitude held by controllers at the rate of the carrier."""
    blocks: dict[str, Block] = {
        "drive": MassSpringDamper(mass=MASS, stiffness=stiffness, damping=3.14e-7),
        "pick": DisplacementReadout(gain=2e5),
        "phase_mixer": Product(first_unit="V"),
        "phase_average": Decimator(ratio=25, unit="V"),
        "loop_filter": PID(
            proportional=250.0, integral=7900.0, derivative_gain=0.0, input_unit="V", output_unit="rad/s"
        ),
        "phase": DiscreteIntegrator(input_unit="rad/s", output_unit="rad"),
        "right_angle": Constant(value=0.5 * math.pi, unit="rad"),
        "force_angle": Constant(value=math.radians(97.2), unit="rad"),
        "cosine_phase": Sum(unit="rad"),
        "force_phase": Sum(unit="rad"),
        "sine": Sine(frequency=CARRIER),
        "cosine": Sine(frequency=CARRIER),
        "force_carrier": Sine(frequency=CARRIER),
        "amplitude_mixer": Product(first_unit="V"),
        "amplitude_average": Decimator(ratio=25, unit="V"),
        "amplitude": Gain(gain=2.0, input_unit="V", output_unit="V"),
        "setpoint": Constant(value=1.0, unit="V"),
        "amplitude_error": Difference(unit="V"),
        "agc": PID(
            proportional=2.7,
            integral=54.0,
            derivative_gain=0.0,
            limited=True,
            lowest=0.0,
            highest=1.0,
            input_unit="V",
            output_unit="V",
        ),
        "excitation": Product(first_unit="V"),
        "comb": CombDrive(linearised=True),
    }
    wires = [
        "drive.displacement -> pick.displacement",
        "pick.voltage -> phase_mixer.first",
        "cosine.output -> phase_mixer.second",
        "phase_mixer.output -> phase_average.input",
        "phase_average.mean -> loop_filter.error",
        "loop_filter.output -> phase.input",
        "phase.output -> sine.phase",
        "phase.output -> cosine_phase.first",
        "right_angle.output -> cosine_phase.second",
        "cosine_phase.output -> cosine.phase",
        "phase.output -> force_phase.first",
        "force_angle.output -> force_phase.second",
        "force_phase.output -> force_carrier.phase",
        "pick.voltage -> amplitude_mixer.first",
        "sine.output -> amplitude_mixer.second",
        "amplitude_mixer.output -> amplitude_average.input",
        "amplitude_average.mean -> amplitude.input",
        "setpoint.output -> amplitude_error.first",
        "amplitude.output -> amplitude_error.second",
        "amplitude_error.output -> agc.error",
        "agc.output -> excitation.first",
        "force_carrier.output -> excitation.second",
        "excitation.output -> comb.voltage",
        "comb.force -> drive.force",
    ]
    return Graph(
        name="drive loop", rate="200 kHz", blocks=blocks, rates={"loop_filter": "8 kHz", "agc": "8 kHz"}, wires=wires
    )


@pytest.mark.defect("S2", before="UNSTABLE at 8000 Hz, stable at 8005 Hz: by the last bit", after="stable, 76.7 deg")
@pytest.mark.parametrize("stiffness", chosen([126.5], [MASS * (2.0 * math.pi * CARRIER) ** 2, 126.4]))
def test_the_phase_of_an_oscillation_is_neutral_whatever_its_frequency(stiffness: float) -> None:
    found = margins(drive(stiffness), "loop_filter.output", at="0.4 s")
    assert found.verdict == "stable"
    assert math.degrees(found.phase_margin or 0.0) == pytest.approx(76.75, abs=0.1)
    assert found.gain_crossovers == pytest.approx([20.5], abs=0.05)
    (mode,) = found.hidden
    assert "the phase of an oscillation" in str(mode)
    assert "phase" in mode.blocks


@pytest.mark.exhaustive("-1.4e-06")
@pytest.mark.exhaustive("-1.4e-06")
@pytest.mark.defect("S670", before="unstable in its last digits, at a gradient moved by 1.4e-6", after="stable at each")
@pytest.mark.parametrize("moved", chosen((-1.4e-6, 1.4e-6), (1e-9,)))
def test_the_phase_of_an_oscillation_that_creeps_is_neutral(moved: float) -> None:
    """The phase moves on by 1e-11 of a turn in a period, far less than a map is compared to."""
    graph = read_graph("library:closed_loop_gyroscope")
    comb = graph.blocks["sense_comb"]
    assert isinstance(comb, CombDrive)
    gradient = comb.capacitance_gradient * (1.0 + moved)
    names = ("sense_comb.capacitance_gradient", "drive_comb.capacitance_gradient")
    found = margins(graph.with_parameters(dict.fromkeys(names, gradient)), "rate", at="settled")
    assert found.verdict == "stable"
    assert found.phase_margin == pytest.approx(math.radians(75.59), abs=1e-3)
    (mode,) = found.hidden
    assert mode.blocks == ("drive.oscillator",)
