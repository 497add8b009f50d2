"""Displacement readout: voltage = gain x + offset (Sarraf et al. 2012, section 2.1, the numerator C of eq. 5).

It stands for capacitor pair, carrier, charge amplifier and demodulator together; its noise is a
WhiteNoise beside it.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class DisplacementReadout(Block):
    """Capacitive readout as one gain."""

    gain: float = param("V/m", "Voltage per displacement.", default=3.530e8)
    offset: float = param("V", "Voltage at rest.", default=0.0)

    displacement = Input("m", "Displacement of the proof mass.")


@DisplacementReadout.output("V")
def voltage(p: DisplacementReadout, displacement: float) -> float:
    """Voltage of the readout."""
    return p.gain * displacement + p.offset
