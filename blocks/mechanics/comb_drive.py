"""Comb drive of varying area: F = 1/2 C' ((Vdc + v)^2 - (Vdc - v)^2) = 2 C' Vdc v (Sarraf et al. 2012, section 3.3).

One-sided: F = 1/2 C' (Vdc + v)^2. Linearised about v = 0 it is 1/2 C' Vdc (Vdc + 2 v). The
push-pull pair is linear as it stands; its linearised form spares the difference of two nearly equal
squares.

C' = 2 N eps0 h / g of N pairs of fingers of height h, a gap g on both sides of each, no fringe. The
default is that of 100 pairs, 25 um and 3 um, with eps0 = 8.8541878128e-12 F/m (CODATA 2018).
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class CombDrive(Block):
    """Electrostatic comb actuator; by default 100 finger pairs, 25 um high, gap 3 um, push-pull."""

    bias: float = param("V", "Constant voltage Vdc between the combs.", default=20.0)
    capacitance_gradient: float = param(
        "F/m", "Change of capacitance of one comb per displacement, C'.", default=1.4756979688e-8, above=0.0
    )
    push_pull: bool = param("", "Whether a second comb pulls the other way with Vdc - v.", default=True)
    linearised: bool = param("", "Whether the terms above first order in v are left out.", default=False)

    voltage = Input("V", "Drive voltage v on top of the bias.")


@CombDrive.output("N")
def force(p: CombDrive, voltage: float) -> float:
    """Force on the proof mass."""
    if p.linearised:
        slope = p.capacitance_gradient * p.bias
        return 2.0 * slope * voltage if p.push_pull else slope * (0.5 * p.bias + voltage)
    pull, push = p.bias + voltage, p.bias - voltage
    squares = pull * pull - push * push if p.push_pull else pull * pull
    return 0.5 * p.capacitance_gradient * squares
