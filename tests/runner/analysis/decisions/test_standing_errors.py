"""Converters whose error stands still: what they are given is constant, or is one of their words."""

from proofmass.blocks import AnalogToDigital, PiecewiseConstant, Sum, WhiteNoise
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.decisions.standing_errors import without_standing
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan

BLOCKS = {
    "noise": WhiteNoise(density="1 mV/sqrt(Hz)", unit="V"),
    "level": PiecewiseConstant(times=(0.0,), values=(0.3,), unit="V"),
    "both": Sum(unit="V"),
    "busy": AnalogToDigital(bits=12, reference="1 V"),
    "quiet": AnalogToDigital(bits=12, reference="1 V"),
}
WIRES = [
    "noise.output -> both.first",
    "level.output -> both.second",
    "both.output -> busy.voltage",
    "level.output -> quiet.voltage",
]


def test_what_stands_still_is_rounded_alike_in_every_tick() -> None:
    """A converter of noise has errors that move; one of a source that stands still has a single one."""
    planned = plan(Graph(name="two converters", rate=1000, blocks=BLOCKS, wires=WIRES))
    noise = noise_blocks(planned)
    assert noise.keys() == {"noise", "busy", "quiet"}
    left = without_standing(planned, start(planned), noise)
    assert left == {name: own for name, own in noise.items() if name != "quiet"}
