"""The comparator against one without delay, shifted, and its delay in a loop against the describing function."""

import numpy as np
import pytest

from proofmass.blocks import Comparator, DelayedComparator, Integrator, Negation
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import noise, response


@pytest.mark.parametrize("delay", [1, 7])
def test_it_is_a_comparator_some_ticks_ago(delay: int) -> None:
    u = noise(300)
    known = response(Comparator(threshold=0.2, hysteresis=0.6), u, "sign")
    block = DelayedComparator(threshold=0.2, hysteresis=0.6, delay=delay)
    assert response(block, u, "sign") == [-1.0] * delay + known[:-delay]
    assert response(block, u, "on") == [value > 0.0 for value in response(block, u, "sign")]


def test_a_loop_with_an_integrator_swings_by_its_delay() -> None:
    """A triangle: the integrator goes on for the delay after each crossing, so a period is four delays."""
    delay = 25
    graph = Graph(
        name="swing",
        rate="1 kHz",
        blocks={
            "integrator": Integrator(gain=1.0, output_unit="1"),
            "comparator": DelayedComparator(delay=delay),
            "minus": Negation(),
        },
        wires=[
            "integrator.output -> comparator.input",
            "comparator.sign -> minus.input",
            "minus.output -> integrator.input",
        ],
        probes=["integrator.output"],
    )
    swing = simulate(graph, samples=2000, engine="python")["integrator.output"].values[1000:]
    rising = np.flatnonzero((swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    assert np.diff(rising) == pytest.approx(4.0 * delay, abs=2.0)
    assert swing.max() == pytest.approx(delay * 1e-3, abs=1.5e-3)
