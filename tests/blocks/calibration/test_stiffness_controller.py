"""The stiffness controller against the sums it stands for, and on a device that is all spring."""

import pytest

from proofmass.blocks import StiffnessController
from tests.by_hand.functions import drive

WINDOW = [False, True, True, True, False, False]


def test_the_error_of_the_window_corrects_once_after_it() -> None:
    block = StiffnessController(initial=50.0, gain=0.5)
    errors = [7.0, 1.0, 2.0, 4.0, 9.0, 9.0]
    samples = [{"measured": 1.0, "modelled": 1.0 + e, "window": w} for e, w in zip(errors, WINDOW, strict=True)]
    found = [row["stiffness"] for row in drive(block, [*samples, *samples])]
    assert found == [50.0] * 4 + [53.5] * 6 + [57.0] * 2


def test_every_chip_corrects_at_once() -> None:
    block = StiffnessController(initial=50.0, gain=0.5, every_chip=True)
    samples = [
        {"measured": 0.0, "modelled": e, "window": w}
        for e, w in zip((7.0, 1.0, 2.0, 4.0, 9.0, 9.0), WINDOW, strict=True)
    ]
    assert [row["stiffness"] for row in drive(block, samples)] == [50.0, 50.5, 51.5, 53.5, 53.5, 53.5]


@pytest.mark.parametrize("true", [40.0, 51.48, 60.0])
def test_on_a_spring_alone_it_finds_the_stiffness(true: float) -> None:
    """The truth is a fixed point, and nothing else is: y = F/k."""
    block = StiffnessController(initial=50.0, gain=1.0)
    stiffness, samples = 50.0, []
    for _ in range(40):
        samples += [{"measured": 353.0 / true, "modelled": 353.0 / stiffness, "window": w} for w in WINDOW]
        stiffness = drive(block, samples)[-1]["stiffness"]
    assert stiffness == pytest.approx(true, rel=1e-6)
