"""Elliptic filters against scipy.signal, sample by sample."""

import pytest
from scipy import signal

from proofmass.blocks import Elliptic
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import distance, noise, response

INPUT = noise(500)


@pytest.mark.parametrize("high", [False, True])
@pytest.mark.parametrize("order", range(1, 9))
@pytest.mark.parametrize(
    ("corner", "ripple", "attenuation"), [(10.0, 3.0, 60.0), (120.0, 0.1, 30.0), (430.0, 0.5, 100.0)]
)
def test_against_scipy(order: int, corner: float, ripple: float, attenuation: float, high: bool) -> None:
    block = Elliptic(order=order, corner_frequency=corner, ripple=ripple, attenuation=attenuation, high_pass=high)
    sections = signal.ellip(order, ripple, attenuation, corner, "high" if high else "low", fs=1000.0, output="sos")
    assert distance(response(block, INPUT, period=1e-3), signal.sosfilt(sections, INPUT)) < 1e-12


def test_an_attenuation_below_the_ripple_is_refused() -> None:
    with pytest.raises(ModelError, match="more than the ripple, 3"):
        Elliptic(ripple=3.0, attenuation=2.0)
