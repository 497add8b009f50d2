"""Thermal expansion: elongation = length s, s = (expansion - frame_expansion) D + quadratic D^2, D = T - T0.

Coefficients are those at T0; `quadratic` is half the slope of the coefficient over temperature. A
beam between two ends of its frame cannot grow: its axial force is -E A s, as long as it does not
buckle (Timoshenko and Gere, Mechanics of Materials, section 2.5). Wire it to a ResonantBeam.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class ThermoelasticExpansion(Block):
    """Growth of a part against its frame, and the axial force where it is clamped: how temperature becomes signal."""

    length: float = param("m", "Length of the part.", default=1e-3, above=0.0)
    expansion: float = param("1/K", "Linear coefficient of the part: of silicon 2.6 ppm/K.", default=2.6e-6)
    quadratic: float = param("1/K^2", "Half the slope of the coefficient, of the part less the frame.", default=0.0)
    frame_expansion: float = param("1/K", "Linear coefficient of the frame; 0 for one that stands still.", default=0.0)
    reference_temperature: float = param("K", "Temperature without stress, T0.", default=298.15, above=0.0)
    stiffness: float = param("N", "Axial stiffness E A: Young's modulus times area.", default=16.9, at_least=0.0)

    temperature = Input("K", "Temperature of part and frame.")


def strain(p: ThermoelasticExpansion, temperature: float) -> float:
    """Free strain against the frame."""
    warmer = temperature - p.reference_temperature
    return (p.expansion - p.frame_expansion + p.quadratic * warmer) * warmer


@ThermoelasticExpansion.output("m")
def elongation(p: ThermoelasticExpansion, temperature: float) -> float:
    """Growth of the free part against its frame."""
    return p.length * strain(p, temperature)


@ThermoelasticExpansion.output("N")
def force(p: ThermoelasticExpansion, temperature: float) -> float:
    """Axial force of the clamped part; tension is positive."""
    return -p.stiffness * strain(p, temperature)
