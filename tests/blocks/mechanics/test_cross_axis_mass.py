"""The force of the model equation, term by term."""

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
