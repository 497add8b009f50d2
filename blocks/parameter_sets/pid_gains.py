"""Gains of D(z) = Kp + Ki Ts z/(z-1) + Kd/Ts (1-a)(z-1)/(z-a), a = exp(-2 pi f Ts), and of what it is made of."""

from proofmass.blocks.declaration.declare import Block, param


class PIDGains(Block):
    """Gains of a PID controller and the pole of its derivative (digital quartz accelerometer, section III.A)."""

    proportional: float = param("({output_unit})/({input_unit})", "Kp, output per error.", default=0.06)
    integral: float = param("({output_unit})/({input_unit})/s", "Ki, output per error and second.", default=6.0)
    derivative_gain: float = param(
        "({output_unit})*s/({input_unit})", "Kd, output per error per second.", default=2.0e-5
    )
    derivative_pole: float = param(
        "Hz", "Frequency of the pole that filters the derivative.", default=2000.0, above=0.0
    )
    input_unit: str = param("", "Unit of the error.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")
