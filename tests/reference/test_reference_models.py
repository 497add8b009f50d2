"""Reference models of digital integrators: registers against the closed form, and what integrators do to the damping.

The rules and rates of the paper's integrators are not known; the table of biases is held against NumPy and SciPy.
"""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import least_squares

from docs.papers import pn_runs
from docs.papers.pn_runs import ACCELEROMETER, GYROSCOPE, IDEAL, RULES, Device, at_rate, calibrate, library
from proofmass.blocks import DiscreteMassSpringDamper
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive

G0 = 9.80665
STEPS = (64, 256, 1024, 4096)
DEVICE = {  # mass, stiffness, damping, chip rate; readout is no matter
    "accelerometer": (50.43e-9, 51.48, 4.57e-3, 4800),
    "gyroscope": (48.67e-9, 137.7, 7.12e-5, 8750),
}


@pytest.fixture(scope="module")
def result() -> Any:
    return simulate(library("fixed_against_floating.toml"))


class TestRegistersAgainstFloatingPoint:
    """Sarraf et al. 2012, section 3.1, Fig. 6: 1 g as a step, and at 90 Hz; words of (24, 6) and (32, 30)."""

    def test_step_against_the_closed_form(self, result: Any) -> None:
        mass, stiffness, damping = 50.43e-9, 49.5627, 3.4e-3
        trace = result["on_step.fixed"]
        t = np.arange(len(trace.values)) * float(trace.period)
        roots = np.roots([mass, damping, stiffness])
        static = 1e6 * mass * G0 / stiffness
        shape = (roots[1] * np.exp(roots[0] * t) - roots[0] * np.exp(roots[1] * t)) / (roots[0] - roots[1])
        exact = static * (1.0 + shape.real)
        assert static == pytest.approx(0.009978, abs=1e-6)
        assert np.max(np.abs(trace.values - exact)) < 2e-3 * static

    def test_sine_against_the_transfer_function(self, result: Any) -> None:
        mass, stiffness, damping = 50.43e-9, 49.5627, 3.4e-3
        trace = result["on_sine.fixed"]
        t = np.arange(len(trace.values)) * float(trace.period)
        s = 2j * math.pi * 90.0
        response = 1e6 * mass * G0 / (mass * s * s + damping * s + stiffness)
        settled = t > 2e-3
        exact = (response * np.exp(s * t)).imag
        assert np.max(np.abs(trace.values - exact)[settled]) < 2e-3 * abs(response)

    def test_largest_differences(self, result: Any) -> None:
        """In every tick, of the peak: 0.14 % after the step, 0.054 % in the sine."""
        values = {name: measure.value for name, measure in result.measures.items()}
        step = max(values["step_above"], -values["step_below"]) / values["step_peak"]
        sine = max(values["sine_above"], -values["sine_below"]) / values["sine_peak"]
        assert step == pytest.approx(1.36e-3, rel=0.02)
        assert sine == pytest.approx(5.37e-4, rel=0.02)


def integrated(mass: float, stiffness: float, damping: float, step: float, method: str) -> Any:
    """Displacement and velocity a step later, from both and from 1 uN."""
    a, b = np.array([[0.0, 1.0], [-stiffness / mass, -damping / mass]]), np.array([0.0, 1e-6 / mass])
    left = np.eye(2)
    if method == "forward_euler":
        right, push = np.eye(2) + step * a, step * b
    elif method == "tustin":
        left, right, push = np.eye(2) - 0.5 * step * a, np.eye(2) + 0.5 * step * a, step * b
    else:  # x - T v = x before, v = v before + T (...)
        left = np.array([[1.0, -step], [0.0, 1.0]])
        right, push = np.array([[1.0, 0.0], step * a[1] + [0.0, 1.0]]), step * b
    return np.vstack([np.column_stack([np.linalg.solve(left, right), np.linalg.solve(left, push)]), [0.0, 0.0, 1.0]])


def impulse_response(chip: Any) -> Any:
    """h[1] to h[15] in units of the static response."""
    x, values = chip[:2, 2], []
    for _ in range(15):
        values.append(x[0])
        x = chip[:2, :2] @ x
    return np.array(values)


@cache
def bias(device: str, steps: int, method: str) -> float:
    """Relative error of the damping of the model whose response fits that of the exact device best."""
    mass, stiffness, damping, rate = DEVICE[device]
    joined = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1e-6 / mass], [0.0, 0.0, 0.0]])
    exact = impulse_response(expm(joined / rate))

    def rest(logarithms: Any) -> Any:
        k, c = stiffness * math.exp(logarithms[0]), damping * math.exp(logarithms[1])
        chip = np.linalg.matrix_power(integrated(mass, k, c, 1.0 / rate / steps, method), steps)
        return (impulse_response(chip) - exact) / np.abs(exact).max()

    expected = math.log1p(stiffness / rate / steps / damping) if method == "forward_euler" else 0.0
    return math.expm1(least_squares(rest, [0.0, expected], xtol=1e-14, ftol=1e-14, gtol=1e-14).x[1])


@pytest.mark.parametrize("device", DEVICE)
@pytest.mark.parametrize("method", RULES)
def test_the_block_is_the_matrix_that_biases_are_of(device: str, method: str) -> None:
    """A chip of 64 steps pushed with 1 uN, then 15 without: x and v after each, of the block and by matrices."""
    mass, stiffness, damping, rate = DEVICE[device]
    acceleration, velocity = RULES[method]
    block = DiscreteMassSpringDamper(
        mass=mass,
        stiffness=stiffness,
        damping=damping,
        acceleration_at_end=acceleration,
        velocity_at_end=velocity,
    )
    step = integrated(mass, stiffness, damping, 1.0 / rate / 64, method)
    rows = drive(block, [{"force": 1e-6 * (n < 64)} for n in range(16 * 64)], 1.0 / rate / 64)
    pushed, free = np.linalg.matrix_power(step, 64), np.linalg.matrix_power(step[:2, :2], 64)
    x = pushed[:2, 2]
    for chip in range(1, 16):
        found = np.array([rows[64 * chip]["displacement"], rows[64 * chip]["velocity"]])
        assert found == pytest.approx(x, rel=1e-8, abs=1e-9 * np.abs(pushed[:2, 2]).max())
        x = free @ x


@pytest.mark.parametrize(
    ("device", "method", "biases"),
    [
        ("accelerometer", "forward_euler", (1.81e-2, 4.51e-3, 1.13e-3, 2.82e-4)),
        ("accelerometer", "semi_implicit", (-4.81e-3, -1.23e-3, -3.09e-4, -7.7e-5)),
        ("accelerometer", "tustin", (1.29e-4, 8.1e-6, 5.0e-7, 3e-8)),
        ("gyroscope", "forward_euler", (3.4026, 0.8506, 0.2126, 5.316e-2)),
        ("gyroscope", "semi_implicit", (5.41e-2, 1.30e-2, 3.21e-3, 8.0e-4)),
        ("gyroscope", "tustin", (9.04e-4, 5.7e-5, 3.5e-6, 2e-7)),
    ],
)
def test_biases_of_the_damping(device: str, method: str, biases: tuple[float, ...]) -> None:
    """With 64, 256, 1024 and 4096 steps a chip."""
    assert [bias(device, steps, method) for steps in STEPS] == pytest.approx(biases, abs=2e-4, rel=5e-4)


@pytest.mark.parametrize(("device", "method"), [("accelerometer", "semi_implicit"), ("gyroscope", "tustin")])
def test_responses_of_the_graph_have_the_same_bias(device: str, method: str) -> None:
    """Of `DiscreteMassSpringDamper` itself, 4096 steps a chip."""
    found = pn_runs.integrator_bias({"accelerometer": ACCELEROMETER, "gyroscope": GYROSCOPE}[device], method, 4096)
    assert found == pytest.approx(bias(device, 4096, method), abs=1e-6)


def with_integrators(device: Device, steps: int) -> Graph:
    """A self-calibration by Gauss-Newton steps whose model and its derivatives are made of digital integrators."""
    graph = at_rate(library("self_calibration_online.toml"), device.rate)
    masses = ("accelerometer", "model", "sensitivity_to_stiffness", "sensitivity_to_damping")
    gains = {"readout": 1.0, "model_readout": 1.0, "by_stiffness": -1.0, "by_damping": -1.0}
    changes: dict[str, Any] = {
        **{f"{name}.mass": device.mass for name in masses},
        **{f"{name}.gain": sign * device.readout for name, sign in gains.items()},
        **{
            f"{name}cells{end}.tail": 0
            for name, end in (("", ""), ("model_", ""), ("", "_by_stiffness"), ("", "_by_damping"))
        },
        "accelerometer.stiffness": device.stiffness,
        "accelerometer.damping": device.damping,
        "controller.initial_stiffness": device.designed[0],
        "controller.initial_damping": device.designed[1],
    }
    graph = graph.with_parameters(IDEAL | changes)
    fast = device.rate * steps
    models = {name: DiscreteMassSpringDamper(mass=device.mass) for name in masses[1:]}
    rates = graph.rates | dict.fromkeys((*models, "spring", "dashpot"), fast)
    return replace(graph, blocks={**graph.blocks, **models}, rates=rates)


@pytest.mark.exhaustive("accelerometer-methods0")
@pytest.mark.parametrize(
    ("device", "methods"),
    [("accelerometer", ("forward_euler", "semi_implicit", "tustin")), ("gyroscope", ("semi_implicit", "tustin"))],
)
def test_a_calibration_finds_the_bias(device: str, methods: tuple[str, ...]) -> None:
    """64 steps a chip; there, forward Euler makes the model of the gyroscope unstable."""
    graph = with_integrators({"accelerometer": ACCELEROMETER, "gyroscope": GYROSCOPE}[device], 64)
    models = ("model", "sensitivity_to_stiffness", "sensitivity_to_damping")
    for method in methods:
        rules = {
            f"{model}.{part}_at_end": value
            for model in models
            for part, value in zip(("acceleration", "velocity"), RULES[method], strict=True)
        }
        found = calibrate(graph.with_parameters(rules), 16).damping[-1]
        assert found == pytest.approx(bias(device, 64, method), abs=2e-4), method


@pytest.mark.exhaustive
def test_the_gyroscope_in_registers_is_right_in_the_mean() -> None:
    """Little damping, a leapfrog of 512 steps: -1.6e-4 of the stiffness and -2.7e-4 of the damping are its rule."""
    found = calibrate(library("self_calibration_gyroscope_fixed.toml"), 64)
    assert found.stiffness[32:].mean() == pytest.approx(-1.6e-4, abs=5e-5)
    assert found.damping[32:].mean() == pytest.approx(-2.7e-4, abs=2e-4)  # three standard errors of 32 periods
    assert found.stiffness[32:].std() < 5e-5
    assert found.damping[32:].std() < 5e-4
    assert not any(found.result.overflows.values())


@pytest.mark.exhaustive
def test_the_loop_in_registers_is_right_in_the_mean() -> None:
    """Controllers of (16, 12): 2e-4 and -1.2e-3 of stiffness and damping, of which -7e-4 is the integrators' rule."""
    result = simulate(library("self_calibration_fixed.toml"), duration=64 * 1023 / 4800 + 1e-4, engine="compiled")
    stiffness = result["stiffness.stiffness"].values[93::93] / 51.48 - 1.0
    damping = result["damping.damping"].values[1:] / 4.57e-3 - 1.0
    assert len(stiffness) == len(damping) == 64
    assert stiffness[16:].mean() == pytest.approx(2e-4, abs=5e-5)  # three standard errors of 48 periods
    assert damping[16:].mean() == pytest.approx(-1.2e-3, abs=1.1e-4)
    assert stiffness[16:].std() < 1.6e-4
    assert damping[16:].std() < 3.2e-4
    assert not any(result.overflows.values())
