"""The force of the model equation, term by term."""

import numpy as np
import pytest

from proofmass.blocks import CrossAxisMass
from tests.by_hand.responses import noise, responses


def test_against_the_model_equation() -> None:
    a, b, c = noise(100, 1, 10.0), noise(100, 2, 10.0), noise(100, 3, 10.0)
    block = CrossAxisMass(
        mass=2.0,
        first_sensitivity=1e-3,
        second_sensitivity=-2e-3,
        second_order=1e-4,
        first_coupling=3e-4,
        second_coupling=-5e-4,
    )
    expected = [
        -2.0 * (x + 1e-3 * y - 2e-3 * z + 1e-4 * x * x + 3e-4 * x * y - 5e-4 * x * z)
        for x, y, z in zip(a, b, c, strict=True)
    ]
    assert responses(block, "force", along=a, first_across=b, second_across=c) == pytest.approx(expected, rel=1e-12)


def test_without_errors_it_is_newtons_law() -> None:
    known = {"along": [9.81], "first_across": [3.0], "second_across": [-4.0]}
    assert responses(CrossAxisMass(mass=0.1), "force", **known) == [pytest.approx(-0.981, rel=1e-15)]


@pytest.mark.derivation(
    CrossAxisMass,
    equation="F = -m (a + s1 b + k2 a^2 + k12 a b), k in s^2/m",
    source="Fourier lines of a tumble under gravity, as IEEE Std 1293 evaluates it: K2 in ug/g^2, Kip in ug/g^2",
    convention="seen from the case: gravity up the axis pushes down; K2 / 2 is in the mean and in the second cosine",
)
def test_the_fourier_lines_of_a_tumble() -> None:
    """At the angle t the axis feels a = g cos t and b = g sin t."""
    g, mass = 9.80665, 2e-3
    k2, kip, lean = 70e-6, -40e-6, 1.5e-3  # g/g^2, g/g^2, rad
    block = CrossAxisMass(mass=mass, first_sensitivity=lean, second_order=k2 / g, first_coupling=kip / g)
    t = 2.0 * np.pi * np.arange(16) / 16.0
    felt = {"along": (g * np.cos(t)).tolist(), "first_across": (g * np.sin(t)).tolist(), "second_across": [0.0] * 16}
    force = responses(block, "force", **felt)
    lines = np.fft.rfft(np.array(force) / (-mass * g)) / 8.0
    assert lines[0].real / 2.0 == pytest.approx(k2 / 2.0, rel=1e-9)
    assert (lines[1].real, -lines[1].imag) == pytest.approx((1.0, lean), rel=1e-9)
    assert (lines[2].real, -lines[2].imag) == pytest.approx((k2 / 2.0, kip / 2.0), rel=1e-9)
