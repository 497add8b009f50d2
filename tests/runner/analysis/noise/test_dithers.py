"""What moves a quantiser's input is that of a map to the quantiser alone, and as a run has it."""

import math

import pytest

from proofmass import noise, read_graph
from proofmass.blocks import AnalogToDigital, DiscreteTransferFunction, WhiteNoise
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.decisions.one_bit import noise_at
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.period_map import period_map
from proofmass.runner.analysis.noise import grid_errors
from proofmass.runner.analysis.noise.budget import budget_at
from proofmass.runner.analysis.noise.grid_errors import errors_about
from proofmass.runner.analysis.noise.validity import dithers
from proofmass.runner.planning.plan import plan


@pytest.mark.exhaustive("magnetic_encoder", "recorded_motion")
@pytest.mark.parametrize(
    ("name", "output"),
    [("recorded_motion", "mean.mean"), ("closed_loop_accelerometer", "dac.code"), ("magnetic_encoder", "cordic.angle")],
)
def test_the_map_to_quantisers_alone_moves_them_as_the_whole_one(name: str, output: str) -> None:
    planned = plan(read_graph(f"library:{name}"))
    points = OperatingPoints(planned, "20 ms")
    about = points.answered(lambda one: one)
    node = tuple(output.rsplit(".", 1))
    noisy = noise_at(about, [node])  # type: ignore[list-item]
    memory = Course(planned).at(about.tick)
    whole = period_map(planned, (), [node], noise=noisy, memory=memory, quantisers=noisy)  # type: ignore[list-item]
    errors, _ = errors_about(about, Ends((), (node,), noise=noisy))  # type: ignore[arg-type]
    expected = {(one.block, one.part): one for one in dithers(errors.of(whole), {})}
    sources = {one.block: one.dither for one in budget_at(points, output).sources if one.dither}
    assert sources, "a comparison of nothing"
    for block, dither in sources.items():
        least = min((one for (of, _), one in expected.items() if of == block), key=lambda one: min(one.change, one.rms))
        assert dither.rms == pytest.approx(least.rms, rel=1e-9)
        assert dither.change == pytest.approx(least.change, rel=1e-9)
        assert math.isfinite(least.change)


@pytest.mark.parametrize("pole", [0.0, 0.5, 0.99])
def test_from_value_to_value_slow_noise_moves_a_converter_by_little(pole: float) -> None:
    """y[n+1] = a y[n] + w[n] has a variance of w^2 / (1 - a^2), and changes of variance 2 (1 - a) as large."""
    size = 3.0
    blocks: dict[str, Block] = {
        "noise": WhiteNoise(density=size * math.sqrt(2.0 / 1000.0), unit="V"),
        "filter": DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, -pole), input_unit="V", output_unit="V"),
        "converter": AnalogToDigital(bits=16, reference=32768.0),
    }
    wires = ["noise.output -> filter.input", "filter.output -> converter.voltage"]
    budget = noise(Graph(name="", rate="1 kHz", blocks=blocks, wires=wires), "converter.number")
    (dither,) = [source.dither for source in budget.sources if source.dither]
    variance = size**2 / (1.0 - pole**2)
    assert dither.rms == pytest.approx(math.sqrt(variance), rel=1e-9)
    assert dither.change == pytest.approx(math.sqrt(2.0 * (1.0 - pole) * variance), rel=1e-9)


WALKING = """
name = "noise that grows and shrinks with a gain"
rate = "1 kHz"
samples = 2000
wires = ["gain.output -> size.first", "noise.output -> size.second", "size.output -> adc.voltage",
         "adc.number -> mean.input"]
probes = ["mean.mean"]
[blocks.gain]
kind = "Sine"
frequency = "2 Hz"
amplitude = 1.0
offset = 1.5
[blocks.noise]
kind = "WhiteNoise"
density = "{density} V/sqrt(Hz)"
unit = "V"
[blocks.size]
kind = "Product"
second_unit = "V"
[blocks.adc]
kind = "AnalogToDigital"
bits = 8
reference = "10 V"
[blocks.mean]
kind = "Decimator"
ratio = 500
"""


@pytest.mark.parametrize("density", ["0.01", "0.002"], ids=["white errors", "too little noise"])
def test_stretches_of_a_period_say_what_all_of_it_does(density: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing lasts before the converter; noise is least at one place of a period of 500 ticks, where the gain is."""
    planned = plan(read_graph_text(WALKING.replace("{density}", density)))
    found = {}
    for stretch in (7, 64, 1 << 20):
        monkeypatch.setattr(grid_errors, "_STRETCH", stretch)
        budget = budget_at(OperatingPoints(planned, "500 ms"), "mean.mean")
        (dither,) = [source.dither for source in budget.sources if source.dither]
        found[stretch] = budget.rms, dither.rms, dither.change, dither.apart, budget.notes
    for stretch in (7, 64):
        assert found[stretch][:3] == pytest.approx(found[1 << 20][:3], rel=1e-9)
        assert found[stretch][3] >= found[1 << 20][3], (
            "only four values of a stretch are asked whether they lie on a grid"
        )
        assert found[stretch][4] == found[1 << 20][4]
    steps = float(density) * math.sqrt(500.0) * 0.5 / (20.0 / 256.0)  # where the gain is at its least
    assert found[7][1] == pytest.approx(steps, rel=0.01)
