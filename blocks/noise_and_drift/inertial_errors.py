"""Errors of one axis in the terms of data sheets, with u what it senses, D = temperature - 298.15 K, a an acceleration:

    output = (1 + scale + scale_temperature D) u + asymmetry |u| + second_order u^2
             + bias + bias_temperature D + acceleration_sensitivity a + noise

The mean that second_order makes of a vibration is the rectification error (IEEE Std 1293, sections
5 and 12; IEEE Std 1431, section 5).
"""

from proofmass.blocks.declaration.declare import Block, Input, param

REFERENCE = 298.15  # K


class InertialErrors(Block):
    """Errors of a gyroscope or an accelerometer, by its data sheet; noise comes by a wire."""

    scale: float = param("1", "Relative error of the scale factor.", default=0.0)
    scale_temperature: float = param("1/K", "Growth of the scale error per kelvin.", default=0.0)
    asymmetry: float = param("1", "Half the difference of the scale factors for positive and negative u.", default=0.0)
    second_order: float = param("1/({unit})", "Quadratic coefficient.", default=0.0)
    bias: float = param("{unit}", "Output at rest.", default=0.0)
    bias_temperature: float = param("({unit})/K", "Growth of the bias per kelvin.", default=0.0)
    acceleration_sensitivity: float = param(
        "({unit})/(m/s^2)", "Sensitivity of a gyroscope to acceleration.", default=0.0
    )
    unit: str = param("", "Unit of input and output.", default="rad/s")

    input = Input("{unit}", "Quantity that the axis senses, u.")
    noise = Input("{unit}", "Noise that is added.", default=0.0)
    acceleration = Input("m/s^2", "Acceleration along the sensitive axis, a.", default=0.0)
    temperature = Input("K", "Temperature.", default=REFERENCE)


@InertialErrors.output("{unit}")
def output(p: InertialErrors, input: float, noise: float, acceleration: float, temperature: float) -> float:
    """Reading of the axis."""
    warmer = temperature - REFERENCE
    scaled = (1.0 + p.scale + p.scale_temperature * warmer) * input
    bent = p.asymmetry * abs(input) + p.second_order * input * input
    return scaled + bent + p.bias + p.bias_temperature * warmer + p.acceleration_sensitivity * acceleration + noise


@InertialErrors.corner
def above_zero(p: InertialErrors, input: float) -> float:
    return input
