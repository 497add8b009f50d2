"""The integral of signals whose integral is known, between ticks and at them."""

import math

import numpy as np
import pytest

from proofmass.blocks import Integrator, LowPass, Step
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate


def integrated(gain: float, initial: float) -> np.ndarray:
    """Of 1 - exp(-2 pi 10 Hz t), at 1 kHz."""
    graph = Graph(
        name="integral",
        rate="1 kHz",
        blocks={
            "step": Step(),
            "filter": LowPass(corner_frequency=10.0),
            "integral": Integrator(gain=gain, initial=initial),
        },
        wires=["step.output -> filter.input", "filter.output -> integral.input"],
        probes=["integral.output"],
    )
    return simulate(graph, samples=200, engine="python")["integral.output"].values


def test_against_the_closed_form() -> None:
    t, w = np.arange(200) * 1e-3, 20.0 * math.pi
    expected = 0.5 + 3.0 * (t - (1.0 - np.exp(-w * t)) / w)
    assert integrated(3.0, 0.5) == pytest.approx(expected, rel=1e-12)


def test_linear_and_without_feedthrough() -> None:
    assert Integrator.linear
    assert Integrator.feedthrough("output") == ()
