"""Fit selector: of two fits the one with the smaller residual; converged = settled and residual < limit.

A resonance above the chip rate answers nearly as its mirror image below it: sampled once a chip the
poles of both are the same. Fits that start on either side of the chip rate find both, and all
samples of a period tell them apart. Beyond Sarraf et al. 2012, whose iteration ends when the error
is below a threshold (section 2.1, step vii).
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class FitSelector(Block):
    """Takes the better of two fits of a reference model, and says whether it is to be believed."""

    residual_limit: float = param(
        "V", "Largest residual of a model that agrees with its device: some noise.", default=5.4e-3, above=0.0
    )

    first_stiffness = Input("N/m", "Stiffness of the first fit.")
    first_damping = Input("kg/s", "Damping of the first fit.")
    first_residual = Input("V", "Difference of its response to that of the device over the last period.")
    first_settled = Input("1", "Whether the first fit has settled.", dtype=bool)
    second_stiffness = Input("N/m", "Stiffness of the second fit.")
    second_damping = Input("kg/s", "Damping of the second fit.")
    second_residual = Input("V", "Difference of its response to that of the device over the last period.")
    second_settled = Input("1", "Whether the second fit has settled.", dtype=bool)


@FitSelector.output("N/m")
def stiffness(
    p: FitSelector, first_stiffness: float, first_residual: float, second_stiffness: float, second_residual: float
) -> float:
    """Stiffness of the better fit."""
    return second_stiffness if second_residual < first_residual else first_stiffness


@FitSelector.output("kg/s")
def damping(
    p: FitSelector, first_damping: float, first_residual: float, second_damping: float, second_residual: float
) -> float:
    """Damping of the better fit."""
    return second_damping if second_residual < first_residual else first_damping


@FitSelector.output("V")
def residual(p: FitSelector, first_residual: float, second_residual: float) -> float:
    """The smaller residual."""
    return second_residual if second_residual < first_residual else first_residual


@FitSelector.output("1")
def converged(
    p: FitSelector, first_residual: float, first_settled: bool, second_residual: float, second_settled: bool
) -> bool:
    """True once the better fit has settled and its residual is no more than noise."""
    if second_residual < first_residual:
        return second_settled and second_residual < p.residual_limit
    return first_settled and first_residual < p.residual_limit
