"""The Coriolis force: its size, and that the pair of them does no work."""

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks.mechanics.coriolis_force import CoriolisForce, force

numbers = st.integers(-(10**6), 10**6).map(lambda n: n / 1024.0)


def test_size_and_sign() -> None:
    assert force(CoriolisForce(mass=0.5), 3.0, 0.25) == -0.75
    assert force(CoriolisForce(mass=0.5, positive=True), 3.0, 0.25) == 0.75


@given(numbers, numbers, numbers)
def test_the_pair_does_no_work(drive: float, sense: float, rotation: float) -> None:
    p = CoriolisForce(mass=2.0)
    on_drive, on_sense = force(CoriolisForce(mass=2.0, positive=True), sense, rotation), force(p, drive, rotation)
    assert on_drive * drive + on_sense * sense == 0.0


@pytest.mark.derivation(
    CoriolisForce,
    equation="F = 2 m Omega v on the drive mode x of the sense velocity y', and -2 m Omega v the other way",
    source="a free particle: a straight line in a frame at rest, seen in axes that turn counter-clockwise, by mpmath",
    convention="whole factor of 2; Omega in rad/s and about x cross y",
)
def test_a_free_particle_seen_from_a_turning_frame() -> None:
    """Its acceleration there, less the centrifugal one."""
    turn, when = 1.3, 0.37

    def seen(axis: int, t: mpmath.mpf) -> mpmath.mpf:
        x, y, c, s = 0.2 - 0.7 * t, -0.1 + 1.9 * t, mpmath.cos(turn * t), mpmath.sin(turn * t)
        return c * x + s * y if axis == 0 else c * y - s * x

    (x, vx, ax), (y, vy, ay) = (
        [float(mpmath.diff(lambda t, axis=axis: seen(axis, t), when, n)) for n in range(3)] for axis in range(2)
    )
    on_drive, on_sense = CoriolisForce(mass=0.25, positive=True), CoriolisForce(mass=0.25)
    assert force(on_drive, vy, turn) == pytest.approx(0.25 * (ax - turn**2 * x), rel=1e-9)
    assert force(on_sense, vx, turn) == pytest.approx(0.25 * (ay - turn**2 * y), rel=1e-9)
