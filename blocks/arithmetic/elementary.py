"""Elementary functions in plain arithmetic: the same bits in every engine, on every machine; they vectorise.

Special values are those of `math`, but where `math` raises: out of range the result is infinite,
and where there is none it is NaN. Each function says within how many units in the last place of the
exact value it is: a little more than the largest error of 10^7 arguments, which
`benchmarks/elementary.py` finds.
"""

from proofmass.blocks.arithmetic.arcs import arccosine, arcsine, arctangent, arctangent2
from proofmass.blocks.arithmetic.circular import cosine, sine, tangent
from proofmass.blocks.arithmetic.exponentials import bounded_exponential, exponential, exponential_less_one
from proofmass.blocks.arithmetic.hyperbolic import hyperbolic_cosine, hyperbolic_sine, hyperbolic_tangent
from proofmass.blocks.arithmetic.logarithms import (
    binary_logarithm,
    decimal_logarithm,
    logarithm,
    logarithm_of_fraction,
    logarithm_of_one_plus,
)
from proofmass.blocks.arithmetic.powers import hypotenuse, power
from proofmass.blocks.arithmetic.turns import cosine_of_turns, sine_of_turns

__all__ = [
    "arccosine",
    "arcsine",
    "arctangent",
    "arctangent2",
    "binary_logarithm",
    "bounded_exponential",
    "cosine",
    "cosine_of_turns",
    "decimal_logarithm",
    "exponential",
    "exponential_less_one",
    "hyperbolic_cosine",
    "hyperbolic_sine",
    "hyperbolic_tangent",
    "hypotenuse",
    "logarithm",
    "logarithm_of_fraction",
    "logarithm_of_one_plus",
    "power",
    "sine",
    "sine_of_turns",
    "tangent",
]
