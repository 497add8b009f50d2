"""Words that people write for units: what they stand for, and what to write."""

from fractions import Fraction

WRITTEN_OUT = {  # names, for which there is a sign
    "second": "s",
    "sec": "s",
    "hr": "h",
    "yr": "year",
    "minute": "min",
    "hour": "h",
    "day": "d",
    "volt": "V",
    "ampere": "A",
    "newton": "N",
    "hertz": "Hz",
    "degree": "deg",
    "radian": "rad",
    "kelvin": "K",
    "gram": "g",
    "meter": "m",
    "metre": "m",
}
ANSWERS = {  # names from elsewhere, and what to write
    "degC": 'temperatures are in K: 25 degC is "298.15 K"',
    "degF": 'temperatures are in K: 77 degF is "298.15 K"',
    "rtHz": "write sqrt(Hz)",
    "dps": "write deg/s",
    "dph": "write deg/h",
    "rpm": 'one turn a minute is "6 deg/s"',
    "gee": "write g0, standard gravity",
    "gn": "write g0, standard gravity",
    "G": 'a gauss is "100 uT"; standard gravity is g0',
    "Ohm": "write ohm",
    "Ohms": "write ohm",
    "psi": 'a pound per square inch is "6894.757 Pa"',
    "in": "write inch",
    "mil": 'a thousandth of an inch is "25.4 um"',
    "sps": "write Hz",
    "dB": "write the factor: 20 dB of an amplitude is 10",
}
SAME = (
    {  # names from elsewhere that stand for an expression
        "rtHz": "sqrt(Hz)",
        "dps": "deg/s",
        "dph": "deg/h",
        "gee": "g0",
        "gn": "g0",
        "Ohm": "ohm",
        "Ohms": "ohm",
        "sps": "Hz",
        "in": "inch",
    }
    | WRITTEN_OUT
    | {f"{word}s": sign for word, sign in WRITTEN_OUT.items()}
)
CELSIUS = {  # factor and offset to kelvin
    name: (Fraction(1), Fraction("273.15")) for name in ("degC", "°C", "℃", "C")
} | {name: (Fraction(5, 9), Fraction("459.67") * 5 / 9) for name in ("degF", "°F", "F")}
COMMON = ("kHz", "MHz", "ms", "us", "ns", "mV", "uV", "pF", "fF", "kg", "mg", "um", "nm", "mm", "kohm", "uN", "mA")
