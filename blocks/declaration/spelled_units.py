"""Quantities as people write them into fields and files: names of units that fit, a prefix that suits, few digits."""

import math
import re
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache

from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.blocks.declaration.units import convertible, fitting

_MOST_DIGITS = 17  # of a float
_LEAST_PLAIN, _MOST_PLAIN = -4, 11  # powers of ten of numbers that are written without one
_WORD = re.compile(r"(?<![A-Za-zµμΩ])(?!sqrt\b)[A-Za-zµμΩ%][A-Za-zµμΩ0-9]*")


@lru_cache(maxsize=512)
def spellings(own: str) -> tuple[tuple[str, tuple[dict[str, Fraction], ...]], ...]:
    """Return forms of units that people write for `own`: with a `?` for each name, and what a name
    there multiplies by.

    >>> ((form, (volts, metres)),) = spellings("V/m")
    >>> form, volts["mV"], metres["um"]
    ('?/?', Fraction(1, 1000), Fraction(1000000, 1))
    >>> spellings("m/s^2")[0][1][0]["g0"]
    Fraction(196133, 20000)
    """
    wanted, factor = unit(own).exponents, unit(own).factor

    def choices(form: str) -> dict[str, Fraction]:
        units = {name: form.replace("?", name) for name in fitting(form, r"\?", wanted)}
        return {name: unit(text).factor / factor for name, text in units.items() if convertible(text, own)}

    whole = choices("?")
    forms: list[tuple[str, tuple[dict[str, Fraction], ...]]] = [("?", (whole,))] if whole else []
    places = list(_WORD.finditer(own))
    if places and places[0][0] != own:
        names = tuple(choices(f"{own[: found.start()]}?{own[found.end() :]}") for found in places)
        forms.append((_WORD.sub("?", own), names))
    return tuple(forms)


def usual_unit(own: str, size: float) -> str:
    """Return a unit with the prefix that suits a number in the unit `own`, as a file has it.

    >>> usual_unit("V/m", 2e7), usual_unit("kg", 5e-8), usual_unit("1/s", 6000.0), usual_unit("m/s^2", 9.8)
    ('MV/m', 'ug', '1/s', 'm/s^2')
    """
    found = _WORD.match(own)
    if not (0.0 < size < math.inf) or found is None:
        return own
    names = {factor: name for name, factor in reversed(spellings(own)[-1][1][0].items()) if name[-1] == found[0][-1]}
    ten = min(3 * math.floor(math.log10(size * (1.0 + 1e-9)) / 3), 0 if found[0] in ("s", "kg") else 9)
    best = min(names, key=lambda factor: (abs(math.log10(factor) - ten), factor))
    return own[: found.start()] + names[best] + own[found.end() :]


def decimal_in(value: float, factor: Fraction) -> str:
    """Return the fewest digits which, times an exact factor, are read back as this very float.

    >>> decimal_in(9.80665, Fraction("9.80665")), decimal_in(5.043e-8, Fraction(1, 10**9))
    ('1', '50.43')
    >>> decimal_in(-1.25e-5, Fraction(1)), decimal_in(6.5e15, Fraction(1)), decimal_in(0.0, Fraction(1))
    ('-1.25e-5', '6.5e15', '0')
    """
    exact, text = Fraction(value) / factor, "0"
    for digits in range(1, _MOST_DIGITS + 1):
        text = f"{Decimal(exact.numerator) / Decimal(exact.denominator):.{digits}g}"
        if float(Fraction(text) * factor) == value:
            break
    number = Decimal(text).normalize()
    power = number.adjusted()
    if not number or _LEAST_PLAIN <= power <= _MOST_PLAIN:
        return format(number, "f")
    return f"{number.scaleb(-power).normalize():f}e{power}"
