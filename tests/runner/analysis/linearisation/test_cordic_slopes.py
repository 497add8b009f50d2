"""Small signals through searches by signs: what CORDIC finds is a sum of constants, but follows its input."""

import math

import pytest

from proofmass import Graph, noise
from proofmass.blocks import (
    Constant,
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
