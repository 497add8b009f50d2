"""Numbers and units as people read them: SI prefixes, powers and products in print."""

import math
import re

from proofmass.blocks.declaration.unit_expressions import unit

_SIGNS = {-24: "y", -21: "z", -18: "a", -15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXED = (
    "m", "g", "s", "A", "K", "rad", "Hz", "N", "Pa", "J", "W", "C", "V", "F", "ohm", "Ω", "S", "Wb", "T", "H", "g0",
)  # fmt: skip
_QUANTITY = re.compile(r"\s*([+-]?[0-9._]+(?:[eE][+-]?[0-9]+)?(?:/[0-9]+)?)\s*(\S.*?)?\s*")
_HOUR = 3600.0
_LONG_TIMES = (("year", 31557600.0), ("d", 86400.0), ("h", _HOUR))  # seconds


def in_print(value: float, unit: str, digits: int = 4) -> str:
    """Return a number with its unit, to so many digits.

    >>> in_print(5.043e-8, "kg"), in_print(24, "1"), in_print(-8e-6, "1/s")
    ('50.43 µg', '24', '−8·10⁻⁶ 1/s')
    """
    factor, text = prefix(unit, abs(value))
    mantissa, _, power = f"{value * factor:.{digits}g}".partition("e")
    number = mantissa.replace("-", "−") + (f"·10{str(int(power)).translate(_RAISED)}" if power else "")
    return number if text == "1" else f"{number} {text}"


def as_written(text: str, value: float, unit: str, digits: int = 6) -> str:
    """Return a quantity as it was written, or in print if it was a number.

    >>> as_written("50.43 ug", 5.043e-8, "kg"), as_written("800 ppm", 8e-4, "1"), as_written("", 3.53e8, "V/m")
    ('50.43 µg', '800 ppm', '353 MV/m')
    >>> as_written("1 year", 31557600.0, "s"), as_written("", 31557600.0, "s"), as_written("", 5400.0, "s")
    ('1 year', '1 year', '1.5 h')
    """
    match = _QUANTITY.fullmatch(text)
    if match:
        return f"{match[1].replace('-', '−')} {pretty(match[2])}" if match[2] else match[1].replace("-", "−")
    if unit == "s" and abs(value) >= _HOUR:
        return long_time(value, digits)
    return in_print(value, unit, digits)


def long_time(seconds: float, digits: int = 6) -> str:
    """Return a time from an hour on in hours, days or years, whichever has the fewest digits.

    >>> long_time(86400.0), long_time(3 * 31557600.0), long_time(3600.0 * 1000)
    ('1 d', '3 years', '1000 h')
    """
    texts = [f"{seconds / size:.{digits}g} {name}" for name, size in _LONG_TIMES if abs(seconds) >= size]
    text = min(texts, key=len)
    return text + "s" if text.endswith("year") and text != "1 year" else text


def relative_text(part: float) -> str:
    """Return a part of a whole in per cent or parts per million.

    >>> relative_text(8e-4), relative_text(0.025), relative_text(0.0)
    ('800 ppm', '2.5 %', '0')
    """
    if not part:
        return "0"
    return f"{100.0 * part:.6g} %" if abs(part) >= 1e-3 else f"{1e6 * part:.6g} ppm"


def display(own: str, wanted: str, largest: float) -> tuple[float, str]:
    """Return a factor and the unit in print for numbers in the unit `own`: in the `wanted` unit, or
    with a prefix.

    >>> factor, unit = display("rad/s", "deg/h", 1e-5)
    >>> round(factor * 1e-5, 9), unit
    (2.062648062, '°/h')
    """
    if not wanted:
        return prefix(own, largest)
    return float(unit(own or "1").factor / unit(wanted).factor), pretty(wanted)


def displayed(value: float, own: str, wanted: str, digits: int = 6) -> str:
    """Return a number with its unit, in the `wanted` one if there is one.

    >>> displayed(1e-5, "rad/s", "deg/h"), displayed(2.5e-3, "V", "")
    ('2.06265 °/h', '2.5 mV')
    """
    if not wanted:
        return in_print(value, own, digits)
    factor, text = display(own, wanted, abs(value))
    return in_print(value * factor, "1", digits) + ("" if text == "1" else f" {text}")


def prefix(unit: str, largest: float) -> tuple[float, str]:
    """Return a factor and the unit with an SI prefix for numbers up to `largest`; (1, unit) if it
    takes no prefix.

    >>> prefix("V", 3e-5)
    (1000000.0, 'µV')
    """
    match = re.fullmatch(r"([A-Za-zµμΩ]+0?)((?![\^\w]).*)", unit)
    parts = _parts(match[1]) if match else None
    if match is None or parts is None or not (0.0 < largest < math.inf):
        return 1.0, pretty(unit)
    power, base = parts
    wanted = 3 * math.floor((math.log10(largest) + power + 1e-9) / 3)
    wanted = min(max(wanted, -24), 0 if base == "s" else 9)
    return float(10.0 ** (power - wanted)), pretty(_SIGNS[wanted] + base + match[2])


def pretty(unit: str) -> str:
    """Return a unit in print, such as m/s² or nV/√Hz."""
    for plain, printed in (("^2", "²"), ("^3", "³"), ("*", "·"), ("ohm", "Ω")):
        unit = unit.replace(plain, printed)
    unit = re.sub(r"\bsqrt\((\w+)\)", r"√\1", unit)
    unit = re.sub(r"^\(([^()]*)\)(?=[/·]|$)", r"\1", re.sub(r"\((\w+)\)", r"\1", unit))
    unit = re.sub(r"\b1·|/1(?![\w.])", "", unit)
    return re.sub(r"\bu(?=[A-ZΩagms])", "µ", re.sub(r"\bdeg\b", "°", unit))


def in_table(unit: str) -> str:
    """Return a unit in print for a column of units; empty for a plain number.

    >>> in_table("m/s^2"), in_table("1")
    ('m/s²', '')
    """
    return "" if unit == "1" else pretty(unit)


def _parts(name: str) -> tuple[int, str] | None:
    """Return power of ten and base unit of a name such as kHz; None for a unit without prefixes."""
    if name in _PREFIXED:
        return 0, name
    for power, sign in _SIGNS.items():
        for spelled in (sign, "u") if sign == "µ" else (sign,):
            if spelled and name.startswith(spelled) and name[len(spelled) :] in _PREFIXED:
                return power, name[len(spelled) :]
    return None
