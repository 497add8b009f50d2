"""Delay margins of loops with two values of the wire in a period, in closed form."""

import math

import pytest

import proofmass
from proofmass.blocks import Constant, Difference, DiscreteTransferFunction, Product, RepeatingSequence
from proofmass.graphs.model.build import Graph


def integrator(gains: tuple[float, ...]) -> Graph:
    """Return y' = y - g y, in which g is one gain after the other."""
    return Graph(
        name="turning gain",
        rate="1 kHz",
        blocks={
            "zero": Constant(value=0.0),
            "error": Difference(),
            "product": Product(),
            "gains": RepeatingSequence(values=gains),
            "sum": DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, -1.0)),
        },
        wires=[
            "zero.output -> error.first",
            "sum.strictly_proper_part -> error.second",
            "error.output -> product.first",
            "gains.output -> product.second",
            "product.output -> sum.input",
        ],
        loops={"main": {"open_at": "sum.strictly_proper_part"}},
    )


@pytest.mark.defect("S674", before="64 ms, whatever the delay", after="the largest delay that is stable")
@pytest.mark.parametrize("low", [0.0, 0.003, 0.008])
def test_an_integrator_of_small_gains(low: float) -> None:
    """z^s (z - 1) = -g is stable up to g = 2 sin(pi / (2 (2 s + 1))). Of small gains the mean counts.

    The mean is right to its square, so the delay is compared to one value.
    """
    mean = 0.5 * (low + 0.012)
    delay = 0.5 * (0.5 * math.pi / math.asin(0.5 * mean) - 1.0)
    found = proofmass.margins(integrator((low, 0.012)), "main")
    assert found.delay_margin is not None
    assert found.delay_margin == pytest.approx(1e-3 * delay, abs=1.1e-3)
    assert delay > 100.0
