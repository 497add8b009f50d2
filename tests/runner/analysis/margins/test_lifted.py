"""Figures of loops with a matrix over a period, where a single number would do: against closed forms."""

import math
from typing import Any

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.margins.lifted import _raised_by_levels, _raised_by_values, figures_of

WIRE = (("x", "output", 0),)


def test_half_of_a_value_three_samples_later() -> None:
    """L = z^-3 / 2 is real at sixths of the rate: negative at one, positive at two, negative at half the rate."""
    matrix = np.zeros((4, 5))
    matrix[0, 3] = matrix[1, 0] = matrix[2, 1] = 1.0
    matrix[3, 2] = -0.5
    states = tuple(("x", f"held_{i}", -1) for i in range(3))
    found = figures_of(OpenLoop(PeriodMap(states, WIRE, WIRE, matrix, {}, 1e-3)), True)
    assert found.phase_crossovers == pytest.approx([1000.0 / 6.0, 500.0])
    assert found.phase_crossover_gains == pytest.approx([0.5, 0.5])
    assert found.gain_crossovers == ()
    assert (found.gain_margin, found.gain_reduction) == (pytest.approx(2.0), None)
    assert (found.phase_margin, found.delay_margin, found.bandwidth) == (None, None, None)
    assert found.sensitivity_peak == pytest.approx(2.0)  # 1 / (1 - 1 / 2)
    assert found.disk_margin == pytest.approx(2.0 / 3.0)  # |S - T| = |1 - L| / |1 + L| is 3 there


def test_an_integrator_of_half_the_input() -> None:
    """L = 1 / (2 z - 2): |L| = 1 at 2 asin(1 / 4), |T|^2 = 1 / (5 - 4 cos w T)."""
    matrix = np.array([[1.0, 1.0, 0.0], [-0.5, 0.0, 0.0]])
    found = figures_of(OpenLoop(PeriodMap((("x", "total", -1),), WIRE, WIRE, matrix, {}, 1e-3)), True)
    turn = 2.0 * math.asin(0.25)
    assert found.gain_crossovers == pytest.approx([1000.0 * turn / (2.0 * math.pi)])
    assert found.phase_margin == pytest.approx(0.5 * math.pi - 0.5 * turn, rel=1e-6)
    assert found.gain_crossover_phases == pytest.approx([0.5 * math.pi - 0.5 * turn])
    assert found.gain_margin == pytest.approx(4.0)
    assert found.bandwidth == pytest.approx(1000.0 * math.acos(0.75) / (2.0 * math.pi))
    assert found.sensitivity_peak == pytest.approx(4.0 / 3.0)
    assert found.sensitivity_peak_frequency == pytest.approx(500.0)


@pytest.mark.parametrize("raised", [_raised_by_levels, _raised_by_values])
@pytest.mark.parametrize(("factor", "samples", "angle"), [(-0.5, 1, 0.0), (0.5, 2, 0.5 * math.pi), (0.5, 1, math.pi)])
def test_the_largest_value_is_found_wherever_it_lies(raised: Any, factor: float, samples: int, angle: float) -> None:
    """1 / (1 + L) of L = f z^-n is 1 / (1 - |f|) where L is -|f|."""
    matrix = np.eye(samples + 1, samples + 2, -1)
    matrix[0, samples], matrix[samples, samples - 1] = 1.0, -factor
    states = tuple(("x", f"held_{i}", -1) for i in range(samples))
    system = OpenLoop(PeriodMap(states, WIRE, WIRE, matrix, {}, 1e-3))
    at, peak = raised(system, 1.0, (0.1, 1.0), lambda level: system.by_values.crossed(level, 1.0, 1e-9, system.hidden))
    assert peak == pytest.approx(2.0, rel=1e-6)
    assert at == pytest.approx(angle, abs=1e-2)


def lock(values: int, turns: int) -> OpenLoop:
    """A phase-locked loop of 300 Hz, whose detector multiplies two carriers: its gain is 1 + cos of twice their phase.

    The states are a control in Hz and turns, 10^5 ticks a second.
    """
    w, tick = 600.0 * math.pi, 1e-5
    moved, rows = np.eye(2, 2 + values), list[Any]()
    for k in range(values):
        error = -(1.0 + math.cos(2.0 * math.pi * turns * k / values + 0.3)) * moved[1]
        rows.append(moved[0] + (math.sqrt(2.0) * w + w * w * tick) * error)
        moved[0] += w * w * tick * error
        moved[1, 2 + k] += tick
    wire = tuple(("x", "output", k) for k in range(values))
    matrix = np.pad(np.vstack([moved, rows]), ((0, 0), (0, 1)))
    return OpenLoop(PeriodMap((("x", "control", -1), ("x", "turns", -1)), wire, wire, matrix, {}, values * tick))


@pytest.mark.defect("S870", before="peaks of 1.117, 1.067 and 1.043", after="1.338")
@pytest.mark.exhaustive("64-26", "32-13")
@pytest.mark.parametrize(("values", "turns"), [(64, 26), (32, 13), (16, 5)])
def test_states_in_units_far_apart_do_not_hide_a_peak(values: int, turns: int) -> None:
    system = lock(values, turns)
    a, b, c, d = (-part if k > 1 else part for k, part in enumerate(system.map.parts()))
    z = np.exp(1j * np.linspace(1e-3, math.pi, 300))[:, None, None]
    sensitivity = np.linalg.inv(np.eye(values) + c @ np.linalg.solve(z * np.eye(2) - a, b + 0j * z) + d)
    found = figures_of(system, True)
    assert found.sensitivity_peak == pytest.approx(np.linalg.norm(sensitivity, 2, axis=(1, 2)).max(), rel=1e-4)
    room = np.linalg.norm(sensitivity - 0.5 * np.eye(values), 2, axis=(1, 2)).max()
    assert found.disk_margin == pytest.approx(1.0 / room, rel=1e-4)
