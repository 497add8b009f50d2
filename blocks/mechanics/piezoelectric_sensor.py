"""Piezoelectric sense electrode: C V' = coupling v - V / R, v the velocity, V the voltage on the capacitance C.

A high-pass of the displacement with the corner 1 / (2 pi R C): V = coupling x / C above it (IEEE
Std 176; Senturia, Microsystem Design, 2001, chapter 21). The charge amplifier of a short-circuited
electrode reads coupling v. The current counts out of the electrode. That of a PiezoelectricActuator
counts in: the coupling of one and the same electrode has the other sign there.
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class PiezoelectricSensor(Block):
    """Piezoelectric readout of a motion: voltage on its own capacitance, or current into a charge amplifier."""

    coupling: float = param("C/m", "Charge per displacement.", default=1e-6)
    capacitance: float = param("F", "Capacitance with that of the wiring, C.", default=10e-12, above=0.0)
    resistance: float = param("ohm", "Leakage and input resistance, R.", default=1e9, above=0.0)

    velocity = Input("m/s", "Velocity of the electrode.")


class State(NamedTuple):
    voltage: float


@PiezoelectricSensor.output("V")
def voltage(p: PiezoelectricSensor, x: State) -> float:
    """Voltage of the open electrode."""
    return x.voltage


@PiezoelectricSensor.output("A")
def current(p: PiezoelectricSensor, velocity: float) -> float:
    """Current of the short-circuited electrode."""
    return p.coupling * velocity


@PiezoelectricSensor.derivative(linear=True)
def derivative(p: PiezoelectricSensor, x: State, velocity: float) -> State:
    return State((p.coupling * velocity - x.voltage / p.resistance) / p.capacitance)
