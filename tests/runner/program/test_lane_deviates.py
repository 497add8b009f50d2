"""Normal deviates of many runs at once against those of each run, to the bit."""

import pytest

from proofmass.blocks import WhiteNoise
from proofmass.blocks.arithmetic.counter_random import is_central, normal_deviate, uniform_deviate
from proofmass.graphs.model.build import Graph
from proofmass.runner.plan.keys import WireOf
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.lane_deviates import normal_deviates
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes


@pytest.mark.parametrize("lanes", [1, 4, 8, 64])
def test_as_plain_python(lanes: int) -> None:
    """Samples in which no lane, some and all need the tails."""
    runs, far = range(lanes), list[int]()
    uniforms, gathered, places, found = ([0] * lanes for _ in range(4))
    for sample in range(60):
        normal_deviates(9, runs, 3, sample, uniforms, gathered, places, found)
        assert found == [normal_deviate(9, run, 3, sample) for run in runs]
        far.append(sum(not is_central(uniform_deviate(9, run, 3, sample) - 0.5) for run in runs))
    assert min(far) == 0 or lanes == 64
    assert max(far) > lanes // 8


def test_compiled() -> None:
    blocks = {"first": WhiteNoise(), "second": WhiteNoise()}
    measures = {name: {"signal": f"{name}.output", "statistic": "last"} for name in blocks}
    planned = plan(Graph(name="", rate=1000, samples=40, blocks=blocks, measures=measures))
    lanes = Lanes(CompiledLanes(planned, set(), 64), 5, range(100), {})
    for tick in (1, 17, 40):
        lanes.advance(tick)
        for name in blocks:
            drawn = [normal_deviate(5, run, planned.stream(name), tick - 1) for run in range(100)]
            scale = planned.constants[name]
            assert lanes.value(WireOf(name, "output")).tolist() == [
                type(blocks[name]).output_functions["output"].function(scale, normal) for normal in drawn
            ]
