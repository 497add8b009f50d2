"""Each error of an axis alone, and what vibration makes of a quadratic one."""

import math
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import InertialErrors
from tests.by_hand.responses import responses

U = [-2.0, -0.5, 0.0, 1.5]
CASES: dict[str, tuple[dict[str, float], dict[str, float], list[float]]] = {
    "none": ({}, {}, U),
    "scale": ({"scale": 0.01}, {}, [-2.02, -0.505, 0.0, 1.515]),
    "scale, warm": ({"scale_temperature": 1e-3}, {"temperature": 308.15}, [-2.02, -0.505, 0.0, 1.515]),
    "asymmetry": ({"asymmetry": 0.1}, {}, [-1.8, -0.45, 0.0, 1.65]),
    "second order": ({"second_order": 0.2}, {}, [-1.2, -0.45, 0.0, 1.95]),
    "bias": ({"bias": 0.25}, {}, [-1.75, -0.25, 0.25, 1.75]),
    "bias, cold": ({"bias_temperature": 0.01}, {"temperature": 288.15}, [-2.1, -0.6, -0.1, 1.4]),
    "sensitivity": ({"acceleration_sensitivity": 0.02}, {"acceleration": 5.0}, [-1.9, -0.4, 0.1, 1.6]),
    "noise": ({}, {"noise": 0.125}, [-1.875, -0.375, 0.125, 1.625]),
}


def sensed(block: InertialErrors, u: list[float], **others: float) -> list[Any]:
    """What the axis reads; inputs that are not told have their defaults."""
    held = {"noise": 0.0, "acceleration": 0.0, "temperature": 298.15} | others
    return responses(block, input=u, **{name: [value] * len(u) for name, value in held.items()})


@pytest.mark.parametrize("case", CASES)
def test_each_error(case: str) -> None:
    parameters, inputs, expected = CASES[case]
    assert sensed(InertialErrors(**parameters), U, **inputs) == pytest.approx(expected, abs=1e-12)


def test_vibration_rectification() -> None:
    """The mean of K2 (A sin)^2 is K2 A^2 / 2."""
    vibration = (3.0 * np.sin(2.0 * np.pi * np.arange(400) / 20.0)).tolist()
    answer = sensed(InertialErrors(unit="m/s^2", second_order=1e-4), vibration)
    assert math.fsum(answer) / 400 == pytest.approx(0.5 * 1e-4 * 9.0, rel=1e-10)
