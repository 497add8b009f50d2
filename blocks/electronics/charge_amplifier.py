"""Charge amplifier: v' = -v / (R C) - q' / C, the transimpedance -s R / (1 + s R C) of a current q'; continuous.

The charge of a capacitive sensor flows into the feedback capacitor C, beside which R takes off what
stays (Sarraf et al. 2012, section 3.2, the transimpedance amplifier). The state is v + q / C.
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class ChargeAmplifier(Block):
    """Transimpedance amplifier of a capacitive readout, an ideal amplifier with capacitor and resistor in feedback."""

    feedback_capacitance: float = param(
        "F",
        "C.",
        default=1e-12,
        above=0.0,
        not_driven="the charge on a capacitor that moves would not stay: drive the gain of a Gain behind it",
    )
    feedback_resistance: float = param("ohm", "R.", default=10e6, above=0.0)

    charge = Input("C", "Charge q on the sensing capacitors.")


class State(NamedTuple):
    rest: float


@ChargeAmplifier.output("V")
def voltage(p: ChargeAmplifier, x: State, charge: float) -> float:
    """Output voltage; inverting."""
    return x.rest - charge / p.feedback_capacitance


@ChargeAmplifier.derivative(linear=True)
def derivative(p: ChargeAmplifier, x: State, charge: float) -> State:
    return State(-(x.rest - charge / p.feedback_capacitance) / (p.feedback_resistance * p.feedback_capacitance))
