"""The unwrapper against NumPy's, and the walk that was wrapped."""

import math

import numpy as np
import pytest

from proofmass.blocks import PhaseUnwrapper
from tests.by_hand.responses import responses


def test_against_numpy() -> None:
    """A walk in steps of up to 3 rad, wrapped."""
    walk = np.cumsum(np.random.default_rng(3).uniform(-3.0, 3.0, 2000))
    wrapped = (walk + math.pi) % math.tau - math.pi
    found = responses(PhaseUnwrapper(), "output", input=wrapped.tolist())
    assert found == pytest.approx(np.unwrap(wrapped), abs=1e-9)
    assert found == pytest.approx(walk, abs=1e-9)


def test_the_first_value_is_the_one_nearest_to_zero() -> None:
    phases = [5.0, 6.0, 0.1]
    assert responses(PhaseUnwrapper(), "output", input=phases) == pytest.approx([5.0 - math.tau, 6.0 - math.tau, 0.1])
