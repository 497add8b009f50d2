"""Coefficients of noise in the units of data sheets: deg/sqrt(h) of a gyroscope, ug0 of an accelerometer.

An angular rate is told by its unit, rad/s, deg/s or °/s: by dimension alone it might as well be a
frequency. Units of a recording that no table has, as degC and dB, stay as they are.
"""

from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert, same_dimension, short_unit, turned

_GYROSCOPE = {"N": "deg/sqrt(h)", "B": "deg/h", "K": "deg/(h*sqrt(h))", "Q": "deg", "density": "deg/(h*sqrt(Hz))"}
_ACCELEROMETER = {
    "N": "m/(s*sqrt(h))", "B": "ug0", "K": "ug0/sqrt(h)", "Q": "m/s", "density": "ug0/sqrt(Hz)",
}  # fmt: skip
_OF = {
    "N": "({unit})/sqrt(Hz)",
    "B": "{unit}",
    "K": "({unit})/sqrt(s)",
    "Q": "({unit})*s",
    "density": "({unit})/sqrt(Hz)",
}
WORDS = {
    "N": "white noise", "B": "bias instability", "K": "random walk", "Q": "quantisation", "density": "density",
}  # fmt: skip
_GYROSCOPE_WORDS = {"N": "angle random walk", "K": "rate random walk"}
_ACCELEROMETER_WORDS = {"N": "velocity random walk", "K": "acceleration random walk"}


def field_unit(quantity: str, unit: str) -> str:
    """Unit of N, B, K, Q or a density of a signal in which data sheets give it."""
    if is_rate(unit):
        return _GYROSCOPE[quantity]
    if _measures(unit, "m/s^2"):
        return _ACCELEROMETER[quantity]
    return short_unit(_OF[quantity].format(unit=unit))


def in_field_unit(quantity: str, value: float, unit: str) -> float:
    """The number of a coefficient in the unit of data sheets, from that in units of the signal and seconds."""
    own, wanted = _OF[quantity].format(unit=unit), field_unit(quantity, unit)
    return value if wanted == short_unit(own) else value * convert(f"1 {own}", wanted)


def word_of(quantity: str, unit: str) -> str:
    """The name that data sheets give a coefficient."""
    own = _GYROSCOPE_WORDS if is_rate(unit) else _ACCELEROMETER_WORDS if _measures(unit, "m/s^2") else {}
    return own.get(quantity, WORDS[quantity])


def is_rate(unit: str) -> bool:
    """Return whether a unit is one of angular rate."""
    return _measures(unit, "rad/s") and bool(turned(unit, "Hz"))


def _measures(unit: str, quantity: str) -> bool:
    try:
        return same_dimension(unit, quantity)
    except UnitError:
        return False
