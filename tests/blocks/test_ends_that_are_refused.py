"""Parameters that others bound: the last value that a block takes, and the first that it refuses."""

from typing import Any

import pytest

from proofmass import blocks
from proofmass.blocks.declaration.problem import ModelError

# A parameter, what it takes at its end, what it refuses next to it, and the parameters that bound it.
ENDS: list[tuple[str, str, Any, Any, dict[str, Any]]] = [
    *((kind, "attenuation", 5.1, 5.0, {"ripple": 5.0}) for kind in ("Elliptic", "EllipticBand")),
    *(
        (kind, "high_frequency", 80.1, 80.0, {"low_frequency": 80.0})
        for kind in ("ButterworthBand", "BesselBand", "ChebyshevType1Band", "ChebyshevType2Band", "EllipticBand")
    ),
    ("BandMeter", "high", 80.1, 80.0, {"low": 80.0}),
    ("ChipCounter", "last", 6, 7, {"chips": 7}),
    ("ChipCounter", "first", 3, 4, {"last": 3, "chips": 7}),
    ("DeadZone", "lowest", 1.0, 1.1, {"highest": 1.0}),
    ("DiscreteIntegrator", "initial", 2.0, 2.1, {"limited": True, "highest": 2.0}),
    ("DiscreteIntegrator", "initial", -1.0, -1.1, {"limited": True}),
    *((kind, "lowest", 0.9, 1.0, {"highest": 1.0}) for kind in ("PID", "Saturation", "Quantiser")),
    ("FlickerNoise", "highest_frequency", 2.1, 2.0, {"lowest_frequency": 2.0}),
    ("FlickerNoise", "highest_frequency", 2e15, 2.1e15, {"lowest_frequency": 2.0}),
    ("FractionalDelay", "delay", 6.9, 7.0, {"longest": 8}),
    ("GaussNewtonController", "last", 6, 7, {"cells": 7, "first": 1}),
    ("GaussNewtonController", "first", 2, 3, {"last": 3, "cells": 7}),
    ("Relay", "lower", 0.9, 1.0, {"upper": 1.0}),
    ("ShiftRegister", "seed", 127, 128, {"length": 7, "taps": 96}),
    ("TemperatureCycle", "high", 280.1, 280.0, {"low": 280.0}),
    ("VectorElement", "index", 6, 7, {"size": 7}),
    ("WrappingIntegrator", "initial", -1.0, -1.1, {"lowest": -1.0, "highest": 1.0}),
    ("WrappingIntegrator", "initial", 0.9, 1.0, {"lowest": -1.0, "highest": 1.0}),
]


@pytest.mark.parametrize(("kind", "name", "taken", "refused", "others"), ENDS)
def test_a_parameter_ends_where_others_say(
    kind: str, name: str, taken: Any, refused: Any, others: dict[str, Any]
) -> None:
    assert getattr(getattr(blocks, kind)(**others, **{name: taken}), name) == taken
    with pytest.raises(ModelError) as caught:
        getattr(blocks, kind)(**others, **{name: refused})
    assert [problem.key.rpartition(".")[2] for problem in caught.value.problems] == [name]
