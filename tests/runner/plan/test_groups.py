"""Which outputs are known a tick ahead, for sources that move as ramps between ticks."""

from proofmass.blocks import Gain, LowPass, Sine, Sum
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan


def test_a_source_that_reaches_a_block_on_two_ways_is_computed_ahead_once() -> None:
    blocks = {"sine": Sine(), "left": Gain(), "right": Gain(gain=2.0), "sum": Sum(), "filter": LowPass()}
    wires = [
        "sine.output -> left.input",
        "sine.output -> right.input",
        "left.output -> sum.first",
        "right.output -> sum.second",
        "sum.output -> filter.input",
    ]
    integration = {"sources": "first_order_hold"}
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=["filter.output"], integration=integration)
    assert plan(graph).ahead == tuple((name, "output") for name in ("sine", "left", "right", "sum"))
