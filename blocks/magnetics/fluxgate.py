"""Fluxgate of two cores excited in opposition: voltage = turns area (flux[n] - flux[n-1]) / T,

    flux = Bs (tanh((H + h) / Hs) - tanh((H - h) / Hs)),   h = field / (mu0 (1 + demagnetisation Bs / (mu0 Hs)))

H is the excitation, and flux that of both cores through one winding, over its area; it is zero
before tick 0. Of a field it makes even harmonics of the excitation alone, the second above all
(Ripka, Magnetic Sensors and Magnetometers, 2001, chapter 3).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.hyperbolic import hyperbolic_tangent
from proofmass.blocks.declaration.declare import Block, Input, param

VACUUM = 1.25663706212e-6  # T m/A, CODATA 2018


class Fluxgate(Block):
    """Field sensor of saturable cores; demodulate its second harmonic, close a loop by a coil."""

    saturation: float = param("T", "Flux density Bs at which the cores saturate.", default=0.6, above=0.0)
    knee: float = param("A/m", "Field Hs of the knee.", default=20.0, above=0.0)
    demagnetisation: float = param("1", "Factor of the shape of a core.", default=2e-3, at_least=0.0, at_most=1.0)
    turns: float = param("1", "Turns of the pick-up winding.", default=500.0, above=0.0)
    area: float = param("m^2", "Cross-section of a core.", default=1e-6, above=0.0)

    excitation = Input("A/m", "Field of the excitation winding, H.")
    field = Input("T", "Flux density to measure.")


class State(NamedTuple):
    flux: float  # over Bs


class Constants(NamedTuple):
    excited: float
    measured: float
    volts: float


@Fluxgate.constants
def constants(p: Fluxgate, period: float) -> Constants:
    shape = VACUUM * p.knee + p.demagnetisation * p.saturation
    return Constants(1.0 / p.knee, 1.0 / shape, p.turns * p.area * p.saturation / period)


def linked(c: Constants, excitation: float, field: float) -> float:
    """Flux through the pick-up winding over Bs and the area."""
    driven, moved = c.excited * excitation, c.measured * field
    return hyperbolic_tangent(driven + moved) - hyperbolic_tangent(driven - moved)


@Fluxgate.output("V")
def voltage(c: Constants, x: State, excitation: float, field: float) -> float:
    """Voltage of the pick-up winding."""
    return c.volts * (linked(c, excitation, field) - x.flux)


@Fluxgate.update
def update(c: Constants, x: State, excitation: float, field: float) -> State:
    return State(linked(c, excitation, field))
