"""The mixer: sine of the phase difference and a ripple of twice the frequency."""

import math

import pytest

from proofmass.blocks import PhaseMixer
from tests.by_hand.responses import responses


@pytest.mark.parametrize("lead", [0.0, 0.01, -0.3, 1.2])
def test_against_the_closed_form(lead: float) -> None:
    phases = [2.0 * math.pi * n / 16.0 for n in range(64)]
    first = [3.0 * math.sin(f + lead) for f in phases]
    second = [0.5 * math.cos(f) for f in phases]
    answer = responses(PhaseMixer(first_amplitude=3.0, second_amplitude=0.5), "phase", first=first, second=second)
    assert answer == pytest.approx([math.sin(lead) + math.sin(2.0 * f + lead) for f in phases], abs=1e-14)
    assert math.fsum(answer) / 64.0 == pytest.approx(math.sin(lead), abs=1e-14)
