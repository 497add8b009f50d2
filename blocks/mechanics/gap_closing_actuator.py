"""Parallel plates that a voltage pulls together (Sarraf et al. 2012, equation 8).

One-sided: F = C0 d V^2 / (2 (d - x)^2), V = Vdc + v. Push-pull: the other plate pulls back with
Vdc - v and x -> -x. About x = 0 the pair has the gain 2 C0 Vdc / d and a spring that softens the
suspension by 2 C0 (Vdc^2 + v^2) / d^2; one plate on a spring k is pulled in at V = sqrt(8 k d^2 /
(27 C0)), where x = d/3. There is no force from the contact on, at x = d or, of a pair, x = -d: a
run ends there.
"""

import math

from proofmass.blocks.declaration.declare import Block, Input, param


class GapClosingActuator(Block):
    """Electrostatic actuator whose plates move towards each other. Let a stop hold them apart."""

    bias: float = param("V", "Constant voltage Vdc.", default=20.0)
    capacitance: float = param("F", "Capacitance C0 of one side at rest.", default=0.1e-12, above=0.0)
    gap: float = param("m", "Gap d at rest.", default=4e-6, above=0.0)
    push_pull: bool = param("", "Whether a second plate pulls the other way with Vdc - v.", default=True)

    voltage = Input("V", "Drive voltage v on top of the bias.")
    displacement = Input("m", "Displacement x towards the plate.")


_TOUCH = "the plates touch: give the mass stops within the gap, as MassBetweenStops has, or less voltage"


@GapClosingActuator.output("N", no_value=_TOUCH)
def force(p: GapClosingActuator, voltage: float, displacement: float) -> float:
    """Force on the proof mass."""
    if displacement >= p.gap or (p.push_pull and displacement <= -p.gap):
        return math.nan
    near, far = p.gap - displacement, p.gap + displacement
    half = 0.5 * p.capacitance * p.gap
    if not p.push_pull:
        return half * (p.bias + voltage) * (p.bias + voltage) / (near * near)
    # Over one denominator: a division is what the integrator waits for.
    pull, pull_back, both = (p.bias + voltage) * far, (p.bias - voltage) * near, near * far
    return half * (pull * pull - pull_back * pull_back) / (both * both)
