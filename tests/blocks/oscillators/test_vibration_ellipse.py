"""The ellipse of a vibration: its axes are looked for along the orbit; Lynch's variables; jumps of the angle."""

import math

import numpy as np
import pytest

from proofmass.blocks import VibrationEllipse
from tests.by_hand.responses import responses

INPUTS = ("x_in_phase", "x_quadrature", "y_in_phase", "y_quadrature")
OUTPUTS = ("amplitude", "quadrature", "modal_angle", "pattern_angle", "phase")


def elements(components: np.ndarray, mode_number: int = 2) -> dict[str, np.ndarray]:
    """The outputs of the block for rows of cx, sx, cy and sy."""
    inputs = dict(zip(INPUTS, components.T.tolist(), strict=True))
    block = VibrationEllipse(unit="1", mode_number=mode_number)
    return {port: np.array(responses(block, port, **inputs)) for port in OUTPUTS}


def of_ellipse(long: float, short: float, angle: float, phase: float) -> np.ndarray:
    """Components of a motion along turned axes: long sin(f + phase) and short cos(f + phase)."""
    turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    sines, cosines = (turned @ np.array(part) for part in (
        (long * math.cos(phase), -short * math.sin(phase)),
        (long * math.sin(phase), short * math.cos(phase)),
    ))  # fmt: skip
    return np.array([sines[0], cosines[0], sines[1], cosines[1]])


@pytest.mark.derivation(
    VibrationEllipse,
    equation="x = cx sin f + sx cos f and y alike: half axes a and q, angle g of the long one, phase d",
    source="the orbit itself, sampled: the farthest and the nearest of its points, where they lie and when",
    convention="g in the modal plane, g / n on the shell; q is above zero where the orbit turns from y to x",
    wrong="nothing",
)
@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_axes_of_the_orbit(seed: int) -> None:
    cx, sx, cy, sy = np.random.default_rng(seed).normal(size=4)
    found = {port: float(values[0]) for port, values in elements(np.array([[cx, sx, cy, sy]]), 3).items()}
    f = np.linspace(0.0, 2.0 * math.pi, 200_001)
    x, y = cx * np.sin(f) + sx * np.cos(f), cy * np.sin(f) + sy * np.cos(f)
    far = int(np.argmax(np.hypot(x, y)))
    assert found["amplitude"] == pytest.approx(np.hypot(x, y).max(), rel=1e-8)
    assert abs(found["quadrature"]) == pytest.approx(np.hypot(x, y).min(), rel=1e-6)
    turns = x[far] * (y[far + 1] - y[far]) - y[far] * (x[far + 1] - x[far])
    assert math.copysign(1.0, found["quadrature"]) == math.copysign(1.0, -turns)
    angle = found["modal_angle"]
    assert math.sin(angle - math.atan2(y[far], x[far])) == pytest.approx(0.0, abs=1e-4)
    assert cx * math.cos(angle) + cy * math.sin(angle) > 0.0
    assert found["pattern_angle"] == pytest.approx(angle / 3.0)
    assert math.cos(f[far] + found["phase"]) == pytest.approx(0.0, abs=1e-4)


def test_a_pattern_that_goes_round_twice() -> None:
    """The modal angle follows from -pi to pi and begins again, with quadrature and phase of either sign."""
    angles = np.linspace(-3.1, 9.4, 400)
    for short, phase in ((0.0, 0.0), (0.02, 0.3), (-0.1, -0.4)):
        found = elements(np.array([of_ellipse(1.5, short, angle, phase) for angle in angles]))
        assert np.unwrap(found["modal_angle"]) == pytest.approx(angles, abs=1e-12)
        assert found["amplitude"] == pytest.approx(np.full(400, 1.5), abs=1e-14)
        assert found["quadrature"] == pytest.approx(np.full(400, short), abs=1e-14)
        assert found["phase"] == pytest.approx(np.full(400, phase), abs=1e-12)


def test_lynchs_variables() -> None:
    rows = np.random.default_rng(7).normal(size=(200, 4))
    cx, sx, cy, sy = rows.T
    found = elements(rows)
    a, q, g, d = found["amplitude"], found["quadrature"], found["modal_angle"], found["phase"]
    assert a**2 + q**2 == pytest.approx(cx**2 + sx**2 + cy**2 + sy**2)
    assert 2.0 * a * q == pytest.approx(2.0 * (cx * sy - cy * sx), abs=1e-12)
    assert (a**2 - q**2) * np.cos(2.0 * g) == pytest.approx(cx**2 + sx**2 - cy**2 - sy**2, abs=1e-12)
    assert (a**2 - q**2) * np.sin(2.0 * g) == pytest.approx(2.0 * (cx * cy + sx * sy), abs=1e-12)
    assert (a**2 - q**2) * np.sin(2.0 * d) == pytest.approx(2.0 * (cx * sx + cy * sy), abs=1e-12)


def test_nothing_has_no_angle_and_a_circle_some_amplitude() -> None:
    still, circle = (elements(np.array([row])) for row in ([0.0] * 4, [1.0, 0.0, 0.0, 1.0]))
    assert all(values[0] == 0.0 for values in still.values())
    assert (circle["amplitude"][0], circle["quadrature"][0]) == pytest.approx((1.0, 1.0))
