"""A loop that settles: its gain comes up by a lag."""

from proofmass.blocks import Constant, Difference, DiscreteTransferFunction, Gain, Product, Step, Sum, UnitDelay
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph


def lagging(at_once: float = 0.0, late: float = 0.0, slow: float = 0.95) -> Graph:
    """x[n + 1] = x[n] + g level[n] (r - x[n]), where the level comes up by a lag; `late` changes it by a step."""
    blocks: dict[str, Block] = {
        **{"reference": Constant(value=1.0), "one": Step(amplitude=late, start_time=0.5, offset=1.0)},
        **{"error": Difference(), "gain": Gain(gain=0.3), "product": Product(), "sum": Sum(), "delay": UnitDelay()},
        "level": DiscreteTransferFunction(numerator=(at_once, 1.0 - slow), denominator=(1.0, -slow)),
    }
    wires = ["reference.output -> error.first", "delay.output -> error.second", "error.output -> gain.input"]
    wires += ["gain.output -> product.first", "one.output -> level.input", "level.output -> product.second"]
    wires += ["product.output -> sum.first", "delay.output -> sum.second", "sum.output -> delay.input"]
    loops = {"main": {"open_at": "product.output"}}
    return Graph(name="lag", rate="1 kHz", duration="1 s", blocks=blocks, wires=wires, loops=loops)
