"""The mixer: sine of the phase difference and a ripple of twice the frequency."""

import math

import pytest

from proofmass.blocks import PhaseMixer
from tests.by_hand.responses import responses


@pytest.mark.derivation(
    PhaseMixer,
    equation="output = 2 first second / (first_amplitude second_amplitude)",
    source="product of a sine and a cosine as half the sines of sum and difference of their angles",
    convention="amplitudes are peaks; 1 per rad at lock, the ripple as large as the whole range",
)
@pytest.mark.parametrize("lead", [0.0, 0.01, -0.3, 1.2])
def test_against_the_closed_form(lead: float) -> None:
    phases = [2.0 * math.pi * n / 16.0 for n in range(64)]
    first = [3.0 * math.sin(f + lead) for f in phases]
    second = [0.5 * math.cos(f) for f in phases]
    answer = responses(PhaseMixer(first_amplitude=3.0, second_amplitude=0.5), "phase", first=first, second=second)
    assert answer == pytest.approx([math.sin(lead) + math.sin(2.0 * f + lead) for f in phases], abs=1e-14)
    assert math.fsum(answer) / 64.0 == pytest.approx(math.sin(lead), abs=1e-14)


def test_its_mean_over_a_turn_is_the_sine_of_the_lead() -> None:
    angles = [2.0 * math.pi * n / 16.0 for n in range(16)]
    first, second = [7.0 * math.sin(f + 0.4) for f in angles], [0.2 * math.cos(f) for f in angles]
    answer = responses(PhaseMixer(first_amplitude=7.0, second_amplitude=0.2), "phase", first=first, second=second)
    assert math.fsum(answer) / 16.0 == pytest.approx(math.sin(0.4), abs=1e-13)
