"""Loops that a limit keeps from growing without end: at rest they are unstable, and so they are called.

An integrator of gain k behind two ticks of delay, x[n+1] = x[n] - k x[n-2], has its closed loop on the unit circle at
k = 2 sin(pi / 10): z^3 - z^2 + k = 0 at z = exp(j pi / 5).
"""

import math

import pytest

from proofmass import Graph, margins, simulate
from proofmass.blocks import Constant, Delay, DiscreteIntegrator, Gain, Saturation, Sum
from proofmass.blocks.declaration.declare import Block
from tests.by_hand.amounts import chosen

EDGE = 2.0 * math.sin(math.pi / 10.0)


def bounded(gain: float) -> Graph:
    """The loop about a constant, with a limit of 1 behind its integrator."""
    blocks: dict[str, Block] = {
        "source": Constant(value=1e-3),
        "error": Sum(),
        "integral": DiscreteIntegrator(output_unit="1", gain=gain * 1000.0),
        "late": Delay(ticks=2),
        "limit": Saturation(),
        "minus": Gain(gain=-1.0),
    }
    wires = [
        "source.output -> error.first",
        "minus.output -> error.second",
        "error.output -> integral.input",
        "integral.output -> late.input",
        "late.output -> limit.input",
        "limit.output -> minus.input",
    ]
    probes = ["limit.output"]
    return Graph(name="bounded", rate=1000.0, duration="1 s", blocks=blocks, wires=wires, probes=probes)


@pytest.mark.defect(
    "S691",
    before="stable, with margins about the oscillation between the limits",
    after="unstable, by the pole of the start",
)
@pytest.mark.parametrize("part", chosen([3.0], [1.1, 1.5]))
def test_an_oscillation_between_limits_does_not_make_a_loop_stable(part: float) -> None:
    graph = bounded(part * EDGE)
    swing = simulate(graph, engine="python")["limit.output"].values[-200:]
    assert swing.max() > 0.9
    assert swing.min() < -0.9, "it does oscillate"
    found = margins(graph, "minus.output")
    assert found.verdict == "unstable"
    (factors,) = found.stable_gains
    assert factors == pytest.approx((0.0, 1.0 / part), rel=1e-9)


@pytest.mark.parametrize("part", [0.5, 0.98])
def test_below_its_edge_it_is_stable(part: float) -> None:
    found = margins(bounded(part * EDGE), "minus.output")
    assert found.stable
    assert found.gain_margin == pytest.approx(1.0 / part, rel=1e-9)
