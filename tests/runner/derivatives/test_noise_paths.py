"""Outputs that noise may reach: all that have a slope somewhere, and not those that only count or compare."""

import pytest

from proofmass import read_graph
from proofmass.blocks import (
    Comparator,
    Constant,
    DiscreteIntegrator,
    FixedQuantiser,
    FixedToNumber,
    Gain,
    MassSpringDamper,
    Sine,
    Sum,
    WhiteNoise,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.graphs.files.library import FOLDER
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.period_map import period_map
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.derivatives.passed_on import reached_by_noise
from proofmass.runner.planning.plan import plan

_SOME = ("chopped_accelerometer", "closed_loop_accelerometer", "recorded_motion", "self_calibration_gyroscope")
_SOME += (
    "closed_loop_gyroscope",
    "magnetic_encoder",
    "quartz_feedback_gain",
    "fibre_optic_gyroscope",
    "carrier_recovery",
)


def test_the_monitor_of_a_calibration_counts_periods_which_no_noise_reaches() -> None:
    planned = plan(read_graph("library:self_calibration_gyroscope"))
    reached = reached_by_noise(planned, noise_blocks(planned))
    assert ("monitor", "periods") not in reached
    assert {("stiffness", "stiffness"), ("damping", "damping"), ("cells", "impulse_response")} <= reached


def test_paths_through_numbers_registers_and_driven_parameters() -> None:
    blocks = {
        "white": WhiteNoise(density=1e-3),
        "signal": Sine(amplitude=1.0, frequency=70.0),
        "sum": Sum(),
        "in": FixedQuantiser(output_format=Fixed(16, 8)),
        "out": FixedToNumber(input_format=Fixed(16, 8)),
        "bit": Comparator(),
        "quiet": DiscreteIntegrator(),
        "stiff": Gain(gain=1.0, output_unit="N/m"),
        "mass": MassSpringDamper(mass=1e-6, damping=1e-3, stiffness=1.0),
        "push": Constant(value=1e-3, unit="N"),
    }
    wires = ["signal.output -> sum.first", "white.output -> sum.second", "sum.output -> in.input"]
    wires += ["in.output -> out.input", "sum.output -> bit.input", "signal.output -> quiet.input"]
    wires += ["out.output -> stiff.input", "stiff.output -> mass.stiffness", "push.output -> mass.force"]
    planned = plan(Graph(name="paths", blocks=blocks, wires=wires, rate="1 kHz", duration="1 s"))
    reached = reached_by_noise(planned, noise_blocks(planned))
    assert {("sum", "output"), ("out", "output"), ("stiff", "output"), ("mass", "displacement")} <= reached
    assert reached.isdisjoint({("signal", "output"), ("quiet", "output"), ("push", "output")})


@pytest.mark.exhaustive(but=3)
@pytest.mark.parametrize("name", _SOME)
def test_whatever_has_a_slope_by_noise_is_reached(name: str) -> None:
    (path,) = FOLDER.rglob(f"{name}.toml")
    planned = plan(read_graph(path))
    noise = noise_blocks(planned)
    reached, course = reached_by_noise(planned, noise), Course(planned)
    wires = [
        (block, port)
        for block in planned.blocks
        for port, declared in type(planned.blocks[block]).outputs.items()
        if not declared.shape and declared.dtype is not bool
    ]
    for tick in (0, 40):
        whole = period_map(planned, (), wires, noise=noise, memory=course.at(tick), span=24, quantisers=())
        moved = whole.matrix[whole.order :, whole.order : -1].any(axis=1)
        found = {entry[:2] for entry, has in zip(whole.outputs, moved, strict=True) if has}
        assert found, "a comparison of nothing"
        assert found <= reached
