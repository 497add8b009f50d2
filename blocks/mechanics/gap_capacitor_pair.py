"""Pair of capacitors with a moving plate between: C1 = C0 / (1 - x), C2 = C0 / (1 + x), x = lever displacement / gap.

For small x the difference is C1 - C2 = k1 displacement with k1 = 2 C0 lever / gap; C1 / (C1 + C2) =
(1 + x) / 2 holds over the whole gap (Sarraf et al. 2012, section 3.2; digital quartz accelerometer,
section II.B.2).
"""

from proofmass.blocks.arithmetic.rounding import saturated
from proofmass.blocks.declaration.declare import Block, Input, param

CONTACT = 1.0 - 2.0**-40  # of the gap: the capacitance of a plate that touches stays a number


class GapCapacitorPair(Block):
    """Differential capacitance of a plate that moves between two fixed ones, which also stop it."""

    capacitance: float = param("F", "C0 of either side, the plate in the middle.", default=42.5e-12, above=0.0)
    gap: float = param("m", "Gap on either side, the plate in the middle.", default=12.5e-6, above=0.0)
    lever: float = param("m/({input_unit})", "Way of the plate per displacement: arm of a pendulum.", default=10e-3)
    input_unit: str = param("", "Unit of the displacement: rad, or m with a lever of 1.", default="rad")

    displacement = Input("{input_unit}", "Displacement or angle; towards the first plate it is positive.")


def part_of_gap(p: GapCapacitorPair, displacement: float) -> float:
    """Way of the plate over the gap, at most to the fixed plates."""
    return saturated(p.lever * displacement / p.gap, -CONTACT, CONTACT)


@GapCapacitorPair.output("F")
def first(p: GapCapacitorPair, displacement: float) -> float:
    """Capacitance to the first plate, C1."""
    return p.capacitance / (1.0 - part_of_gap(p, displacement))


@GapCapacitorPair.output("F")
def second(p: GapCapacitorPair, displacement: float) -> float:
    """Capacitance to the second plate, C2."""
    return p.capacitance / (1.0 + part_of_gap(p, displacement))


@GapCapacitorPair.corner
def before_first(p: GapCapacitorPair, displacement: float) -> float:
    return CONTACT - p.lever * displacement / p.gap


@GapCapacitorPair.corner
def before_second(p: GapCapacitorPair, displacement: float) -> float:
    return CONTACT + p.lever * displacement / p.gap
