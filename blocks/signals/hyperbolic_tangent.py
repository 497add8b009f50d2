"""Hyperbolic tangent of a signal: output = limit tanh(input / limit): a slope of 1 at zero, and a soft limit."""

from proofmass.blocks.arithmetic.elementary import hyperbolic_tangent
from proofmass.blocks.declaration.declare import Block, Input, param


class HyperbolicTangent(Block):
    """Soft saturation: a differential pair, a magnetic core. Saturation has corners."""

    limit: float = param("{unit}", "What the output comes near to.", default=1.0, above=0.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "What is limited.")


@HyperbolicTangent.output("{unit}")
def output(p: HyperbolicTangent, input: float) -> float:
    """The input within its soft limit."""
    return p.limit * hyperbolic_tangent(input / p.limit)
