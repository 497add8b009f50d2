"""Sigma-delta modulator: x_i[n+1] = x_i + g_i (x_(i-1) - f_i v), x_0 = u, v = the level nearest to the last x.

Delaying integrators in a chain with feedback to each. The levels are equally spaced from -reference
to reference; a tie goes up. `resonance` takes so much of the last integrator from the input of the
one before: a zero of the noise at atan(sqrt(g h resonance)) / (2 pi) of the rate, g and h the gains
of these two. Gains (1), (0.5, 0.5): Boser and Wooley, IEEE J. Solid-State Circuits 23, 1988; of
higher orders by coefficients: Schreier and Temes, Understanding Delta-Sigma Data Converters,
chapter 4.
"""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.rounding import nearest_level
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class SigmaDeltaModulator(Block):
    """Oversampling quantiser of order 1 to 8 that shapes its noise, of any number of `levels`."""

    gains: tuple[float, ...] = param("1", "g of each integrator, the first at the input.", default=(0.5, 0.5))
    feedback: tuple[float, ...] = param("1", "f of each integrator.", default=(1.0, 1.0))
    resonance: float = param("1", "Part of the last integrator that goes back by one.", default=0.0, at_least=0.0)
    levels: int = param("1", "Levels of the quantiser.", default=2, at_least=2, at_most=65536)
    reference: float = param("{unit}", "The highest level.", default=1.0, above=0.0)
    unit: str = param("", "Unit of the input.", default="V")

    input = Input("{unit}", "Value to convert.")

    weights = Buffer("g.", float, ("gains",))
    returns = Buffer("f.", float, ("feedback",))
    integrators = Buffer("x, zero in tick 0.", float, ("gains",))


@SigmaDeltaModulator.requires
def requires(p: SigmaDeltaModulator) -> Iterator[tuple[str, str]]:
    if len(p.gains) > 8:
        yield "gains", "at most 8 numbers"
    if len(p.feedback) != len(p.gains):
        yield "feedback", f"{len(p.gains)} numbers, as gains has"


@SigmaDeltaModulator.start
def start(p: SigmaDeltaModulator, weights: list[float], returns: list[float]) -> None:
    weights[:], returns[:] = p.gains, p.feedback


@SigmaDeltaModulator.output("1")
def code(p: SigmaDeltaModulator, integrators: list[float]) -> int:
    """Number of the level, from 0: the bit of a modulator with two."""
    last = float(p.levels - 1)
    return int(nearest_level((0.5 * integrators[-1] / p.reference + 0.5) * last, last))


@SigmaDeltaModulator.output("{unit}")
def output(p: SigmaDeltaModulator, integrators: list[float]) -> float:
    """The level."""
    return p.reference * (2.0 * float(code(p, integrators)) / float(p.levels - 1) - 1.0)


@SigmaDeltaModulator.update
def update(
    p: SigmaDeltaModulator, integrators: list[float], weights: list[float], returns: list[float], input: float
) -> None:
    v, before, order = output(p, integrators), input, len(integrators)
    last = integrators[-1]
    for i in range(order):
        back = p.resonance * last if i == order - 2 else 0.0
        now = integrators[i]
        integrators[i] = now + weights[i] * (before - returns[i] * v - back)
        before = now
