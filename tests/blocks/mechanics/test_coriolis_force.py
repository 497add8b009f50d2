"""The Coriolis force: its size, and that the pair of them does no work."""

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
