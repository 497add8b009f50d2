"""Instrumentation amplifier: output = (1 + Rf / Rg) input (digital quartz accelerometer, section II.B.3, k_amp).

A relative change e of Rf changes the gain G by (G - 1) / G e: of -200 ppm, -180 ppm arrive at a
gain of 10.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class InstrumentationAmplifier(Block):
    """Amplifier of a bridge, its gain set by two resistors that may drift."""

    feedback_resistance: float = param("ohm", "Rf.", default=90.0e3, at_least=0.0)
    gain_resistance: float = param("ohm", "Rg.", default=10.0e3, above=0.0)

    voltage = Input("V", "Difference between the inputs.")


@InstrumentationAmplifier.output("V")
def output(p: InstrumentationAmplifier, voltage: float) -> float:
    """The amplified difference."""
    return (1.0 + p.feedback_resistance / p.gain_resistance) * voltage
