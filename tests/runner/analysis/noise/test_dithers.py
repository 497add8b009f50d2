"""What moves a quantiser's input is that of a map to the quantiser alone, and as a run has it."""

import math

import pytest

from proofmass import read_graph
from proofmass.runner.analysis.decisions.one_bit import noise_at
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.period_map import period_map
from proofmass.runner.analysis.noise.budget import budget_at
from proofmass.runner.analysis.noise.grids import errors_about
from proofmass.runner.analysis.noise.validity import dithers
from proofmass.runner.planning.plan import plan


@pytest.mark.exhaustive("magnetic_encoder")
@pytest.mark.parametrize(
    ("name", "output"),
    [("recorded_motion", "mean.mean"), ("closed_loop_accelerometer", "dac.code"), ("magnetic_encoder", "cordic.angle")],
)
def test_the_map_to_quantisers_alone_moves_them_as_the_whole_one(name: str, output: str) -> None:
    planned = plan(read_graph(f"library:{name}"))
    points = OperatingPoints(planned, "20 ms")
    about = points.answered(lambda one: one)
    node = tuple(output.rsplit(".", 1))
    noise = noise_at(about, [node])  # type: ignore[list-item]
    whole = period_map(planned, (), [node], noise=noise, memory=Course(planned).at(about.tick))  # type: ignore[list-item]
    errors, _ = errors_about(about, Ends((), (node,), noise=noise))  # type: ignore[arg-type]
    expected = {(one.block, one.part): one for one in dithers(errors.of(whole), {})}
    sources = {one.block: one.dither for one in budget_at(points, output).sources if one.dither}
    assert sources, "a comparison of nothing"
    for block, dither in sources.items():
        least = min((one for (of, _), one in expected.items() if of == block), key=lambda one: min(one.change, one.rms))
        assert dither.rms == pytest.approx(least.rms, rel=1e-9)
        assert dither.change == pytest.approx(least.change, rel=1e-9)
        assert math.isfinite(least.change)
