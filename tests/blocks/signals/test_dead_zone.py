"""The dead zone by hand, and its describing function against the closed form."""

import math

import pytest

from proofmass.blocks import DeadZone
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import response


def test_by_hand() -> None:
    block = DeadZone(lowest=-1.0, highest=0.5)
    assert response(block, [-3.0, -1.0, -0.75, 0.0, 0.5, 0.75, 2.5]) == [-2.0, 0.0, 0.0, 0.0, 0.0, 0.25, 2.0]


@pytest.mark.parametrize("amplitude", [0.6, 1.0, 20.0])
def test_the_fundamental_of_its_response_to_a_sine(amplitude: float) -> None:
    """N(A) = 1 - 2 / pi (asin(w / A) + w / A sqrt(1 - (w / A)^2)) (Gelb and Vander Velde, appendix B)."""
    points = 20_000
    sine = [math.sin(2.0 * math.pi * (n + 0.5) / points) for n in range(points)]
    answer = response(DeadZone(), [amplitude * s for s in sine])
    part = 0.5 / amplitude
    expected = 1.0 - 2.0 / math.pi * (math.asin(part) + part * math.sqrt(1.0 - part * part))
    assert 2.0 / points / amplitude * math.fsum(a * s for a, s in zip(answer, sine, strict=True)) == pytest.approx(
        expected, abs=1e-6
    )


def test_ends_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(ModelError, match=r"at most highest = 0\.5"):
        DeadZone(lowest=0.6)
