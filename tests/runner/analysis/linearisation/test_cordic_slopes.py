"""Small signals through searches by signs: what CORDIC finds is a sum of constants, but follows its input."""

import math

import pytest

from proofmass import Graph, noise
from proofmass.blocks import (
    Constant,
    Decimator,
    FixedCast,
    FixedCordicAngle,
    FixedCordicExponential,
    FixedCordicExponentialPipeline,
    FixedCordicRotation,
    FixedCordicVectoring,
    FixedQuantiser,
    FixedToNumber,
    Sum,
    WhiteNoise,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.analysis.linearisation import forward

DENSITY, ANGLE = 1e-3, 0.5
VECTORS = [
    (FixedCordicVectoring(input_format=Fixed(18, 16)), "phase", Fixed(19, 16), 1.0),
    (FixedCordicAngle(input_format=Fixed(18, 16)), "angle", Fixed(16, 16), 0.5 / math.pi),
]


def slope_of(block: Block, word: Fixed, output: str, result: Fixed, **more: Block) -> float:
    """Return the slope of an output by the input, which stands at the angle: density of both together, less one."""
    blocks: dict[str, Block] = {
        "angle": Constant(value=ANGLE),
        "white": WhiteNoise(density=DENSITY),
        "sum": Sum(),
        "word": FixedQuantiser(output_format=word),
        "block": block,
        "number": FixedToNumber(input_format=result),
        "both": Sum(),
        **more,
    }
    wires = ["angle.output -> sum.first", "white.output -> sum.second", "sum.output -> word.input"]
    wires += [f"block.{output} -> number.input", "number.output -> both.first", "sum.output -> both.second"]
    wires += ["word.output -> rotation.angle"] if "rotation" in more else ["word.output -> block.angle"]
    if "rotation" in more:
        wires += ["rotation.cosine -> real.input", "rotation.sine -> imaginary.input"]
        wires += ["real.output -> block.real", "imaginary.output -> block.imaginary"]
    graph = Graph(name="cordic", rate=1000, blocks=blocks, wires=wires, probes=["both.output"])
    budget = noise(graph, "both.output", frequencies=[1e-3])
    (source,) = (each for each in budget.sources if each.block == "white")
    return math.sqrt(source.density[0]) / DENSITY - 1.0


@pytest.mark.exhaustive("sine-0")
@pytest.mark.defect(
    "S697",
    before="no noise reaches what a CORDIC block finds: margins, responses and budgets take its slope for 0",
    after="the slope of sine, cosine, exponential and angle",
)
@pytest.mark.parametrize(("output", "slope"), [("sine", math.cos(ANGLE)), ("cosine", -math.sin(ANGLE))])
def test_rotation(output: str, slope: float) -> None:
    assert slope_of(FixedCordicRotation(), Fixed(19, 16), output, Fixed(18, 16)) == pytest.approx(slope, rel=1e-4)


@pytest.mark.exhaustive("FixedCordicExponentialPipeline")
@pytest.mark.parametrize("kind", [FixedCordicExponential, FixedCordicExponentialPipeline])
def test_exponential(kind: type[Block]) -> None:
    block = kind(fraction_bits=16)
    found = slope_of(block, Fixed(16, 16, signed=False), "exponential", Fixed(18, 16, signed=False))
    assert found == pytest.approx(math.exp(ANGLE), rel=1e-4)


@pytest.mark.exhaustive
@pytest.mark.parametrize(("block", "output", "result", "slope"), VECTORS)
def test_vectoring(block: Block, output: str, result: Fixed, slope: float) -> None:
    """After a rotation: the angle comes back."""
    cast = FixedCast(input_format=Fixed(18, 16), output_format=Fixed(18, 16))
    more = {"rotation": FixedCordicRotation(), "real": cast, "imaginary": cast}
    assert slope_of(block, Fixed(19, 16), output, result, **more) == pytest.approx(slope, rel=2e-4)


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize(
    ("block", "output", "result", "slope"),
    [
        (FixedCordicExponential(fraction_bits=16), "exponential", Fixed(18, 16, signed=False), math.exp(ANGLE)),
        *VECTORS,
    ],
    ids=lambda value: type(value).__name__,
)
def test_machine_code(block: Block, output: str, result: Fixed, slope: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """It brings the rest of a search, which integers drop."""
    monkeypatch.setattr(forward, "_FEW", 0)
    if output == "exponential":
        assert slope_of(block, Fixed(16, 16, signed=False), output, result) == pytest.approx(slope, rel=2e-4)
    else:
        test_vectoring(block, output, result, slope)


@pytest.mark.defect(
    "H912", before="'32767.99 does not fit (16, 16), which holds -0.5 to 0.49998'", after="1 / (2 pi r)"
)
@pytest.mark.parametrize("ratio", [1, 64])
def test_an_angle_that_rounds_to_half_a_turn_has_the_slope_of_its_neighbours(ratio: int) -> None:
    """One step of the imaginary part is 1 / (2 pi r) of a turn, whether half a turn is reached or left."""
    length = 2.0**22
    blocks: dict[str, Block] = {
        "real": Constant(value=-length),
        "white": WhiteNoise(density=0.1),
        "left": FixedQuantiser(output_format=Fixed(24, 0)),
        "up": FixedQuantiser(output_format=Fixed(24, 0)),
        "block": FixedCordicAngle(input_format=Fixed(24, 0), iterations=30, guard_bits=20),
        "number": FixedToNumber(input_format=Fixed(16, 16)),
        "mean": Decimator(ratio=ratio),
    }
    wires = ["real.output -> left.input", "white.output -> up.input", "left.output -> block.real"]
    wires += ["up.output -> block.imaginary", "block.angle -> number.input", "number.output -> mean.input"]
    graph = Graph(name="", rate=1000, blocks=blocks, wires=wires)
    (source,) = (each for each in noise(graph, "mean.mean", at="0.2 s").sources if each.block == "white")
    assert source.rms == pytest.approx(0.1 * math.sqrt(500.0 / ratio) / (2.0 * math.pi * length), rel=1e-3)
