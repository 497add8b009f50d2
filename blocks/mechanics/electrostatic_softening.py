"""Electrostatic softening: F = 2 C0 V^2 x / (d^2 (1 - (x / d)^2)^2), a plate between two others at one voltage V.

About x = 0 it is a negative stiffness of 2 C0 V^2 / d^2: it tunes a resonance, or hides a spring
(Kaajakari, Practical MEMS, 2009, section 13.2).
"""

import math

from proofmass.blocks.declaration.declare import Block, Input, param

_TOUCH = "the plates touch: give the mass stops within the gap, as MassBetweenStops has, or less voltage"


class ElectrostaticSoftening(Block):
    """Negative spring of a symmetric pair of electrodes: frequency tuning, mode matching."""

    capacitance: float = param("F", "Capacitance C0 of one side at rest.", default=0.1e-12, above=0.0)
    gap: float = param("m", "Gap d at rest.", default=4e-6, above=0.0)

    voltage = Input("V", "Voltage between the plate and both electrodes.")
    displacement = Input("m", "Displacement x.")


@ElectrostaticSoftening.output("N", no_value=_TOUCH)
def force(p: ElectrostaticSoftening, voltage: float, displacement: float) -> float:
    """Force on the plate, away from the middle."""
    u = displacement / p.gap
    rest = 1.0 - u * u
    if rest <= 0.0:
        return math.nan
    return 2.0 * p.capacitance * voltage * voltage * u / (p.gap * rest * rest)
