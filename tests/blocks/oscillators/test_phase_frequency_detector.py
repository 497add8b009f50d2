"""The detector against two flip-flops with a common reset, its mean, and what it says of two frequencies."""

import math

import numpy as np
import pytest

from proofmass.blocks import PhaseFrequencyDetector
from tests.by_hand.responses import responses


def flip_flops(reference: list[bool], signal: list[bool]) -> list[float]:
    up = down = False
    before, outputs = (False, False), []
    for r, s in zip(reference, signal, strict=True):
        up |= r and not before[0]
        down |= s and not before[1]
        if up and down:
            up = down = False
        outputs.append(float(up) - float(down))
        before = (r, s)
    return outputs


def test_against_flip_flops_on_random_bits() -> None:
    dice = np.random.default_rng(1)
    reference, signal = (dice.integers(0, 2, 3000).astype(bool).tolist() for _ in range(2))
    assert responses(PhaseFrequencyDetector(), reference=reference, signal=signal) == flip_flops(reference, signal)


@pytest.mark.exhaustive("1", "900")
@pytest.mark.derivation(
    PhaseFrequencyDetector,
    equation="output = level (up - down); its mean is level d / (2 pi)",
    source="area of the pulses between the edges of two square waves, counted",
    convention="per turn, not per half turn: level / (2 pi) per rad; positive where the reference is ahead",
)
@pytest.mark.parametrize("late", [1, 300, 900])
def test_its_mean_is_the_phase_within_a_turn(late: int) -> None:
    reference = [n % 1000 < 500 for n in range(20_000)]
    signal = [n >= late and (n - late) % 1000 < 500 for n in range(20_000)]
    ahead = responses(PhaseFrequencyDetector(level=3.0), reference=reference, signal=signal)
    assert math.fsum(ahead) / 20_000 == pytest.approx(3.0 * late / 1000.0, rel=1e-12)
    behind = responses(PhaseFrequencyDetector(level=3.0), reference=signal, signal=reference)
    assert math.fsum(behind) / 20_000 == pytest.approx(-3.0 * late / 1000.0, rel=1e-12)


def test_the_sign_of_a_frequency_difference() -> None:
    reference, signal = [n % 10 < 5 for n in range(5000)], [n % 13 < 6 for n in range(5000)]
    assert min(responses(PhaseFrequencyDetector(), reference=reference, signal=signal)[20:]) == 0.0
    assert max(responses(PhaseFrequencyDetector(), reference=signal, signal=reference)[20:]) == 0.0
