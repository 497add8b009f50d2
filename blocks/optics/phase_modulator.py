"""Phase modulator: phase = pi voltage / half_wave_voltage (Lefevre, The Fiber-Optic Gyroscope, 2014, section 3.2)."""

import math

from proofmass.blocks.declaration.declare import Block, Input, param


class PhaseModulator(Block):
    """Electro-optic modulator: a drifting half-wave voltage is the error a 2 pi reset measures."""

    half_wave_voltage: float = param("V", "Voltage of half a wave.", default=3.5, above=0.0)

    voltage = Input("V", "Voltage on the electrodes.")


@PhaseModulator.output("rad")
def phase(p: PhaseModulator, voltage: float) -> float:
    """Phase of the light."""
    return math.pi * voltage / p.half_wave_voltage
