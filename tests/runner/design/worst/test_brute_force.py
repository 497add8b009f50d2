"""Worst cases against brute force over 3^n places and random points, by closed forms of four systems.

The closed forms stand here alone, in arrays: an integrating loop, a resonator between two ticks, two coupled loops,
and the quartz accelerometer with eight tolerances.
"""

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from proofmass import Graph, read_graph
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.design.worst.worst import worst
from tests.by_hand.amounts import amounts
from tests.by_hand.design_texts import COUPLED, INTEGRATING, RESONATOR

Values = dict[str, Any]  # arrays by parameter


class System(NamedTuple):
    """A graph, what varies, a quantity, the side on which it is bad, and its closed form."""

    graph: Callable[[], Graph]
    tolerances: Values
    quantity: dict[str, Any]
    side: str
    closed_form: Callable[[Values], Any]
    rounding: float  # of the closed form; a sweep over frequencies misses some of a peak


def noise_of_the_integrating_loop(p: Values) -> Any:
    """y[n+1] = y[n] - k (y[n-1] + noise[n-1]): the variance of its output, k^2 of that of the noise at its input."""
    k = p["controller.gain"] * p["plant.gain"] * 1e-3
    variance = 0.5 * p["hiss.density"] ** 2 / 1e-3
    # of y[n+1] - y[n] + k y[n-1] = w: (1 + a2) / ((1 - a2) ((1 + a2)^2 - a1^2)), a1 = -1, a2 = k
    return np.sqrt(variance * k**2 * (1.0 + k) / ((1.0 - k) * ((1.0 + k) ** 2 - 1.0)))


def held(z: Any, gain: Any, inertia: Any, damping: Any, stiffness: Any, period: float) -> Any:
    """Response of gain / (m s^2 + b s + c) at ticks to an input that is held over a period."""
    root = np.sqrt((damping / (2.0 * inertia)) ** 2 - stiffness / inertia + 0j)
    first, second = -damping / (2.0 * inertia) + root, -damping / (2.0 * inertia) - root
    part = gain / inertia / (first - second)
    terms = [(part, first), (-part, second)]
    return sum(r / pole * (np.exp(pole * period) - 1.0) / (z - np.exp(pole * period)) for r, pole in terms)


def gain_of_the_resonator(p: Values) -> Any:
    z = np.exp(2j * np.pi * 1600.0 / 20e3)
    stiff = p["sensor.stiffness"]
    return np.abs(held(z, p["readout.gain"], p["sensor.mass"], p["sensor.damping"], stiff, 1.0 / 20e3))


def peak_of_the_coupled_loops(p: Values) -> Any:
    """1 / |1 + L| of the loop y with x closed, at its highest over a sweep."""
    z = np.exp(2j * np.pi * np.geomspace(0.5, 499.0, 400) * 1e-3)[:, None]
    step = 1e-3 / (z - 1.0)
    of_x, of_y = step * p["x_plant.gain"], step * p["y_plant.gain"]
    control_x, control_y = (p[f"{axis}_gain.gain"] * p[f"{axis}_minus"] / z for axis in "xy")
    inner = of_x * control_x / (1.0 + of_x * control_x)
    loop = control_y * of_y * (1.0 - inner * p["x_cross.gain"] * p["y_cross.gain"])
    return 20.0 * np.log10(np.max(1.0 / np.abs(1.0 + loop), axis=0))


def phase_margin_of_quartz(p: Values) -> Any:
    """Of C(z) 8 gains ZOH(pendulum), 20 us: the last crossover, by bisection."""
    period, steps = 20e-6, 48
    decay = np.exp(-2.0 * np.pi * 2000.0 * period)

    def loop(f: Any) -> Any:
        z = np.exp(2j * np.pi * f * period)
        integral = p["pid.integral"] * period * z / (z - 1.0)
        derivative = p["pid.derivative_gain"] / period * (1.0 - decay) * (z - 1.0) / (z - decay)
        chain = 8.0 * p["pickoff.gain"] * p["torquer.gain"] / 342.0
        pendulum = held(z, chain, p["pendulum.inertia"], p["pendulum.damping"], p["pendulum.stiffness"], period)
        return (p["pid.proportional"] + integral + derivative) * pendulum

    low, high = np.full(len(p["pickoff.gain"]), 1.0), np.full(len(p["pickoff.gain"]), 20e3)
    for _ in range(steps):
        middle = np.sqrt(low * high)
        over = np.abs(loop(middle)) >= 1.0
        low, high = np.where(over, middle, low), np.where(over, high, middle)
    return np.abs(np.degrees(np.angle(-loop(low))))


QUARTZ = (
    "pickoff.gain",
    "torquer.gain",
    "pid.proportional",
    "pid.integral",
    "pid.derivative_gain",
    "pendulum.inertia",
    "pendulum.damping",
    "pendulum.stiffness",
)
SYSTEMS = {
    "integrating": System(
        lambda: read_graph_text(INTEGRATING),
        {"controller.gain": "30 %", "plant.gain": "20 %", "hiss.density": "10 %"},
        {"noise": "plant.output"},
        "highest",
        noise_of_the_integrating_loop,
        1e-9,
    ),
    "resonator": System(
        lambda: read_graph_text(RESONATOR),
        {"sensor.mass": "5 %", "sensor.stiffness": "5 %", "sensor.damping": "20 %", "readout.gain": "2 %"},
        {"response": "readout.voltage", "input": "force.output", "frequency": "1600 Hz"},
        "highest",
        gain_of_the_resonator,
        1e-6,
    ),
    "coupled": System(
        lambda: read_graph_text(COUPLED),
        {f"{axis}_{part}.gain": "20 %" for axis in "xy" for part in ("plant", "cross", "gain")},
        {"loop": "y", "figure": "sensitivity_peak"},
        "highest",
        lambda p: peak_of_the_coupled_loops({**p, "x_minus": 1.0, "y_minus": 1.0}),
        1e-3,
    ),
    "quartz": System(
        lambda: read_graph("library:closed_loop_accelerometer"),
        dict.fromkeys(QUARTZ, "20 %"),
        {"loop": "main", "figure": "phase_margin"},
        "lowest",
        phase_margin_of_quartz,
        1e-6,
    ),
}
SLOW = ("integrating", "coupled", "quartz")  # a worst case takes seconds


@pytest.mark.parametrize("count", amounts(50, 100_000))
@pytest.mark.parametrize("name", [name for name in SYSTEMS if name not in SLOW])
def test_nothing_is_worse(name: str, count: int) -> None:
    nothing_is_worse(SYSTEMS[name], count)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", SLOW)
def test_nothing_is_worse_in_larger_systems(name: str) -> None:
    nothing_is_worse(SYSTEMS[name], 100_000)


def nothing_is_worse(system: System, count: int) -> None:
    found = worst(system.graph(), {"it": system.quantity}, tolerances=system.tolerances)
    case = next(case for case in found.cases if case.side == system.side)
    assert case.nominal is not None
    assert case.worst is not None
    size, ranges = len(found.ranges), found.ranges
    one = system.closed_form({r.name: np.array([r.nominal]) for r in ranges})
    assert float(np.ravel(one)[0]) == pytest.approx(case.nominal, rel=max(system.rounding, 1e-6))
    corners = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=size)))
    random = np.random.default_rng(19).uniform(-1.0, 1.0, (count, size))
    sign = 1.0 if system.side == "lowest" else -1.0
    for places in np.array_split(np.vstack([corners, random]), -(-(len(corners) + count) // 5000)):
        values = {r.name: r.nominal + places[:, i] * (r.high - r.nominal) for i, r in enumerate(ranges)}
        brute = system.closed_form(values)
        assert float(np.min(sign * (brute - case.worst))) >= -system.rounding * abs(case.worst)
    if not case.inside:
        at = {r.name: np.array([r.at(case.places[r.written])]) for r in ranges}
        assert float(np.ravel(system.closed_form(at))[0]) == pytest.approx(case.worst, rel=max(system.rounding, 1e-6))
