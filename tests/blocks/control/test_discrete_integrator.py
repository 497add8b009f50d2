"""The forward Euler integrator against its difference equation, and at its limits."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.signal import lfilter

from proofmass.blocks import DiscreteIntegrator
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def integrals(block: DiscreteIntegrator, inputs: list[float], period: float) -> list[float]:
    return [row["output"] for row in drive(block, [{"input": u} for u in inputs], period)]


def test_sum_of_the_inputs_before_the_tick() -> None:
    inputs = [0.25 * ((5 * n) % 11 - 4) for n in range(60)]
    exact = [Fraction(3, 2) + Fraction(3, 8) * sum(map(Fraction, inputs[:n])) for n in range(60)]
    assert integrals(DiscreteIntegrator(gain=3.0, initial=1.5), inputs, 0.125) == exact


def test_against_the_transfer_function() -> None:
    inputs = np.random.default_rng(1).normal(size=300)
    expected = lfilter([0.0, 7.0 * 1e-3], [1.0, -1.0], inputs)
    assert integrals(DiscreteIntegrator(gain=7.0), inputs.tolist(), 1e-3) == pytest.approx(expected, abs=1e-14)


def test_it_stops_at_a_limit_and_leaves_it_at_once() -> None:
    block = DiscreteIntegrator(limited=True, lowest=-2.0, highest=3.0)
    inputs = [1.0] * 10 + [-1.0] * 10 + [1.0]
    assert integrals(block, [*inputs, 0.0], 1.0) == (
        [0.0, 1.0, 2.0] + [3.0] * 8 + [2.0, 1.0, 0.0, -1.0] + [-2.0] * 6 + [-1.0]
    )


def test_no_feedthrough() -> None:
    assert DiscreteIntegrator.feedthrough("output") == ()


def test_a_start_beyond_the_limits_is_refused() -> None:
    with pytest.raises(ModelError, match=r"expected: within the limits, -1 to 1"):
        DiscreteIntegrator(limited=True, initial=1.5)
    assert DiscreteIntegrator(initial=1.5).initial == 1.5
    with pytest.raises(ModelError, match=r"expected: less than highest = -1"):
        DiscreteIntegrator(highest=-1.0)
