"""Piezoelectric actuator: F = coupling V - stiffness x, charge q = coupling x + capacitance V.

Of a stack of n discs of thickness t and area A: coupling = n d33 A / (s33 n t), stiffness = A /
(s33 n t), the capacitance is that of the blocked stack; both lines share one coupling (IEEE Std
176, section 2).
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class PiezoelectricActuator(Block):
    """Force of a piezoelectric drive on a mass, and the charge that its amplifier delivers."""

    coupling: float = param("N/V", "Blocked force per voltage, the same as charge per displacement.", default=1e-6)
    stiffness: float = param("N/m", "Stiffness of the short-circuited actuator.", default=0.0, at_least=0.0)
    capacitance: float = param("F", "Capacitance of the blocked actuator.", default=1e-12, above=0.0)

    voltage = Input("V", "Voltage V.")
    displacement = Input("m", "Displacement x of its end, along the force.", default=0.0)


@PiezoelectricActuator.output("N")
def force(p: PiezoelectricActuator, voltage: float, displacement: float) -> float:
    """Force on the mass."""
    return p.coupling * voltage - p.stiffness * displacement


@PiezoelectricActuator.output("C")
def charge(p: PiezoelectricActuator, voltage: float, displacement: float) -> float:
    """Charge on the electrodes."""
    return p.coupling * displacement + p.capacitance * voltage
