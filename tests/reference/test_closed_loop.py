"""The closed-loop accelerometer against a straight-line program: every output code of a million samples."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proofmass.blocks import DriftRamp, Ramp
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import simulate

GRAPH = library_file("closed_loop_accelerometer.toml")
SAMPLES = 1_000_000


def straight_line_program(samples: int, adc_drift: float = 0.0, dac_drift: float = 200e-6) -> list[int]:
    """The loop written out by hand, operation by operation; the hold of the overdamped pendulum in closed form.

    The references of the converters drift in proportion to time, by so much in 20 s.
    """
    inertia, damping, stiffness = 1.0e-7, 4.0e-4, 3.0e-3
    period = 1.0 / 50e3
    mean, half = damping / (2.0 * inertia), math.sqrt((damping / (2.0 * inertia)) ** 2 - stiffness / inertia)
    slow, fast = math.exp((half - mean) * period), math.exp((-half - mean) * period)
    even, odd = (slow + fast) / 2.0, (slow - fast) / (2.0 * half)
    a11, a12 = even + mean * odd, odd
    a21, a22 = -stiffness / inertia * odd, even - mean * odd
    b1, b2 = (1.0 - a11) / stiffness, odd / inertia
    alpha = math.exp(-2.0 * math.pi * 2000.0 * period)
    theta = omega = integral = derivative = last = 0.0
    codes = []
    for n in range(samples):
        acceleration = 9.80665 * (0.5 + 0.1 * math.sin(2.0 * math.pi * 10.0 * n * period))
        code = min(max(round(8.0e3 * theta / (5.0 * (1.0 + adc_drift * n / SAMPLES)) * 2**23), -(2**23)), 2**23 - 1)
        error = float(-code)
        integral += 6.0 * period * error
        derivative = alpha * derivative + 2.0e-5 / period * (1.0 - alpha) * (error - last)
        last = error
        out = min(max(round(0.06 * error + integral + derivative), -(2**19)), 2**19 - 1)
        voltage = out * 2.5 * (1.0 + dac_drift * n / SAMPLES) / 2**19
        torque = 8.0e-6 * acceleration + 0.065 * voltage / 342.0
        theta, omega = a11 * theta + a12 * omega + b1 * torque, a21 * theta + a22 * omega + b2 * torque
        codes.append(out)
    return codes


@pytest.mark.exhaustive
def test_every_output_code_equals_the_straight_line_program() -> None:
    result = simulate(read_graph(GRAPH), samples=SAMPLES, engine="compiled")
    codes = result["dac.code"].values
    assert codes.dtype == np.int64
    assert np.array_equal(codes, straight_line_program(SAMPLES))
    # Published checksums of the workload: mean and standard deviation of the record.
    assert abs(codes.mean() - -43279.078921) < 1e-6
    assert abs(codes.std() - 6213.355134729) < 1e-8


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("ramp", [Ramp(offset=5.0, slope=0.05, unit="V"), DriftRamp(slope=0.01, nominal=5.0, unit="V")])
@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_every_output_code_with_a_drifting_reference_of_the_converter_in_the_feedback(
    ramp: Block, engine: EngineName
) -> None:
    """20 % in 20 s, on the analog-to-digital converter: by its value and relative to it."""
    graph = read_graph(GRAPH)
    output = next(iter(type(ramp).outputs))
    graph = replace(
        graph,
        blocks={**graph.blocks, "drift": ramp},
        wires=[*graph.wires, f"drift.{output} -> adc.reference"],
    )
    samples = 10_000 if engine == "python" else 200_000
    codes = simulate(graph, samples=samples, engine=engine)["dac.code"].values
    drifting = straight_line_program(samples, adc_drift=0.2)
    assert np.array_equal(codes, drifting)
    assert drifting != straight_line_program(samples)


def test_scale_factor_of_the_closed_loop() -> None:
    """8827.40 codes per m/s^2: K0 R 2^19 / (kt Vref), with the sign of the feedback."""
    steady = read_graph(GRAPH).with_parameters({"acceleration.amplitude": 0.0, "reference.slope": 0.0})
    codes = simulate(steady, samples=50_000)["dac.code"].values[25_000:]
    expected = -8.0e-6 * 342.0 * 2**19 / (0.065 * 2.5)
    assert abs(expected + 8827.40) < 0.01
    assert abs(codes.mean() / (0.5 * 9.80665) / expected - 1.0) < 1e-6
