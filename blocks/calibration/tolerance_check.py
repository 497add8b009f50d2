"""Tolerance check: inside = |k / k0 - 1| <= tolerance of k and |c / c0 - 1| <= tolerance of c."""

from proofmass.blocks.declaration.declare import Block, Input, param


class ToleranceCheck(Block):
    """Check that stiffness and damping are those of a good device."""

    stiffness_nominal: float = param("N/m", "k0.", default=51.48, above=0.0)
    stiffness_tolerance: float = param("1", "Relative deviation of a good device at most.", default=0.05, at_least=0.0)
    damping_nominal: float = param("kg/s", "c0.", default=4.57e-3, above=0.0)
    damping_tolerance: float = param("1", "Relative deviation of a good device at most.", default=0.2, at_least=0.0)

    stiffness = Input("N/m", "Stiffness, true or identified.")
    damping = Input("kg/s", "Damping, true or identified.")


@ToleranceCheck.output("1")
def inside(p: ToleranceCheck, stiffness: float, damping: float) -> bool:
    """True if both are within their tolerances."""
    return (
        abs(stiffness - p.stiffness_nominal) <= p.stiffness_tolerance * p.stiffness_nominal
        and abs(damping - p.damping_nominal) <= p.damping_tolerance * p.damping_nominal
    )
