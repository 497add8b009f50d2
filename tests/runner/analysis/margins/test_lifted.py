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
