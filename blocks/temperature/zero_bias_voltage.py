"""Zero bias: voltage = a1 exp(b1 V) + a2 exp(b2 V) + offset + hysteresis (play - V) / width (Liu, Li, Shen, eq. 1).

V is the voltage of the temperature sensor, and the play follows it (play operator): in each tick it
is the play before, held between V - width and V + width. So warming and cooling differ by twice the
hysteresis, which no function of the temperature takes off. The hysteresis is assumed; the paper
shows what remains, not its form.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.temperature.double_exponential_model import double_exponential


class ZeroBiasVoltage(Block):
    """Output of an accelerometer at rest: a law of two exponentials of the temperature, and its thermal hysteresis."""

    a1: float = param("V", "First exponential at 0 V of the sensor.", default=0.1764237)
    b1: float = param("1/V", "Exponent of the first exponential.", default=-6.0)
    a2: float = param("V", "Second exponential at 0 V of the sensor.", default=3.239676e-4)
    b2: float = param("1/V", "Exponent of the second exponential.", default=1.5)
    offset: float = param("V", "Constant part.", default=0.0)
    hysteresis: float = param("V", "Amplitude of the hysteresis; cooling lies above warming.", default=0.0)
    width: float = param("V", "Sensor voltage over which half the hysteresis turns.", default=0.05, above=0.0)

    sensor_voltage = Input("V", "Voltage of the temperature sensor.")


class State(NamedTuple):
    play: float


def play_after(p: ZeroBiasVoltage, before: float, voltage: float, tick: int) -> float:
    """Return the position of the play once the sensor has moved to the voltage; at the start it has no distance."""
    return voltage if tick == 0 else clip(before, voltage - p.width, voltage + p.width)


@ZeroBiasVoltage.output("V")
def voltage(p: ZeroBiasVoltage, x: State, sensor_voltage: float, tick: int) -> float:
    """The zero bias."""
    law = double_exponential(p.a1, p.b1, p.a2, p.b2, sensor_voltage)
    distance = play_after(p, x.play, sensor_voltage, tick) - sensor_voltage
    return law + p.offset + p.hysteresis * (distance / p.width)


@ZeroBiasVoltage.update
def update(p: ZeroBiasVoltage, x: State, sensor_voltage: float, tick: int) -> State:
    return State(play_after(p, x.play, sensor_voltage, tick))
