"""The section against scipy.signal, alone and in series."""

import pytest
from scipy import signal

from proofmass.blocks import SecondOrderSection
from tests.by_hand.responses import distance, noise, response

INPUT = noise(500)


def section(row: list[float]) -> SecondOrderSection:
    return SecondOrderSection(**dict(zip(("b0", "b1", "b2", "a1", "a2"), [*row[:3], *row[4:]], strict=True)))


def test_against_lfilter() -> None:
    answer = response(section([0.3, -0.2, 0.7, 1.0, -1.2, 0.8]), INPUT)
    assert distance(answer, signal.lfilter([0.3, -0.2, 0.7], [1.0, -1.2, 0.8], INPUT)) < 1e-13


@pytest.mark.parametrize("order", [4, 7])
def test_sections_of_an_elliptic_filter_in_series(order: int) -> None:
    sections = signal.ellip(order, 0.5, 60.0, 0.2, output="sos")
    answer = INPUT
    for row in sections.tolist():
        answer = response(section(row), answer)
    assert distance(answer, signal.sosfilt(sections, INPUT)) < 1e-12
