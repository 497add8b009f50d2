"""Quantities: a number with a unit, converted exactly, and what a wrong unit was meant to be."""

import math
import re
from difflib import SequenceMatcher
from fractions import Fraction
from functools import lru_cache

from proofmass.blocks.declaration.unit_expressions import UNITS, UnitError, is_unit, padded, power_of_a_unit, unit
from proofmass.blocks.declaration.unit_words import ANSWERS, CELSIUS, SAME

_OF_COMMON = ("G", "M", "k", "m", "u", "n", "p", "f")  # prefixes in hints

_LIKE, _LIKE_OF_SHORT = 0.55, 0.5  # least likeness of a name to the one that was meant; with the same first letter

_POWER = re.compile(r"(?<![A-Za-z0-9])([A-Za-zµ]+)([2-6])(?![0-9])")  # as in m/s2
_STANDARD_GRAVITY = re.compile(r"(?<![A-Za-zµμ])([A-Zacdfhkmnpuyzµμ]?)g(?![A-Za-z0-9])")
_SIMPLE_BRACKET = re.compile(r"(?<!\w)\((\w+)\)")  # not that of sqrt(Hz)
_FACTOR_OF_ONE = re.compile(r"(?<![\w.^-])1\*|[*/]1(?![\w.^])")
_NAME, _PARTS = re.compile(r"[^\W\d_]+|[%°]"), ("%", "ppm", "ppb")
_ANGLE = re.compile(r"(?<![A-Za-zµμ])[A-Za-zµμ]{0,2}rad(?![A-Za-z])|(?<![A-Za-z])deg(?![A-Za-z])|°")
_TURNS = re.compile(r"(?<![A-Za-zµμ])[A-Za-zµμ]{0,2}Hz(?![A-Za-z])")
_HERTZ, _RADIANS = re.compile(r"Hz(/|$)"), re.compile(r"rad/s(/|$)")
_VANISHING = Fraction(1, 2**1075)  # the largest number that is rounded to zero
_TURN, _HUGE = Fraction(2.0 * math.pi), 10**300  # rad, and what is told in digits no more
_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(?:[0-9][0-9_]*\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?(?:/[0-9]+)?)\s*(?P<unit>.*?)\s*"
)


def same_dimension(first: str, second: str) -> bool:
    """Return whether two unit expressions measure the same quantity."""
    return first == second or unit(first).exponents == unit(second).exponents


def same_unit(first: str, second: str) -> bool:
    """Return whether a number in the one unit is the same number in the other."""
    return first == second or unit(first) == unit(second)


def short_unit(unit: str) -> str:
    """A unit without the brackets about single names and the factors of one that filling in units leaves.

    >>> short_unit("(V)/(m/s^2)"), short_unit("(1)*(1)"), short_unit("(1)/s")
    ('V/(m/s^2)', '1', '1/s')
    """
    return _FACTOR_OF_ONE.sub("", _SIMPLE_BRACKET.sub(r"\1", unit))


def named_unit(expression: str) -> str:
    """Return the name of a coherent unit of the same dimension, empty where there is none.

    >>> named_unit("V/(V/m)"), named_unit("kg*m/s^2"), named_unit("V/m")
    ('m', 'N', '')
    """
    wanted = unit(expression).exponents
    return next((name for name, (factor, own, _) in UNITS.items() if factor == 1 and padded(own) == wanted), "")


def convert(text: str, target: str) -> float:
    """The number, in the unit `target`, of a quantity such as `"50 kHz"`.

    The decimal is read exactly, rounded once, so `"50.43e-9 kg"` is the same float as `50.43e-9`.

    >>> convert("50 uN", "N")
    5e-05
    """
    try:
        return float(convert_exactly(text, target))
    except OverflowError:
        raise UnitError("too large for a number") from None


def part_of(text: str, per: str = "1") -> float | None:
    """Return a part of a value, or one per time; None for a width, which has a unit of its own.

    >>> part_of("5 %"), part_of("0.05"), part_of("5 deg"), part_of("1 V/V"), part_of("2 %/s", "1/s")
    (0.05, 0.05, None, None, 0.02)
    """
    try:
        part, names = convert(text, per), _NAME.findall(split_quantity(text)[1])
    except UnitError:
        return None
    return part if all(name in _PARTS or same_dimension(name, "s") for name in names) else None


@lru_cache(4096)  # graphs repeat their quantities, and a file is often read again
def convert_exactly(text: str, target: str) -> Fraction:
    """Convert without rounding; rates are kept like this."""
    number, symbol = split_quantity(text, target)
    if not symbol:
        return not_vanishing(number)
    target_unit = unit(target)
    try:
        source_unit = unit(symbol)
    except UnitError as error:
        meant = _of_dimension(number, symbol, target) if str(error).startswith("unknown unit") else ""
        raise UnitError(str(error), meant or error.hint) from None
    if source_unit.exponents != target_unit.exponents:
        message = f"{symbol} is {source_unit.in_base_units()}, not {target_unit.in_base_units()}"
        raise UnitError(message, _other_dimension(text, symbol, target))
    value = number * source_unit.factor / target_unit.factor
    _refuse_turns(symbol, target, value)
    return not_vanishing(value)


def not_vanishing(value: Fraction) -> Fraction:
    """Return a number; raises `UnitError` for one that is not zero, and would be as a float."""
    if 0 < abs(value) <= _VANISHING:
        raise UnitError("too small for a number")
    return value


def convertible(first: str, second: str) -> bool:
    """Return whether numbers in the first unit can be told in the second: of one dimension, not angle for turns."""
    counted = {turning_of_unit(short_unit(first)), turning_of_unit(short_unit(second))}
    return same_dimension(first, second) and counted != {(1, 0), (0, 1)} and not turned(first, second)


def turned(one: str, wanted: str) -> str:
    """Return what a unit counts and what is wanted where these are angle and turns a second, which are one dimension.

    >>> turned("deg/s", "Hz"), turned("kHz", "rad/s"), turned("1/s", "Hz")
    ('angle, not turns a second', 'turns, not angle a second', '')
    """
    angle, turns = bool(_ANGLE.search(one)), bool(_TURNS.search(one))
    if angle and not turns and _HERTZ.match(short_unit(wanted)):
        return "angle, not turns a second"
    return "turns, not angle a second" if turns and not angle and _RADIANS.match(short_unit(wanted)) else ""


def turning_of_unit(name: str) -> tuple[int, int] | None:
    """Return the exponents of angle and of turns in a unit; None where it names them below a stroke, or twice.

    >>> turning_of_unit("mrad/s"), turning_of_unit("Hz/V"), turning_of_unit("kg"), turning_of_unit("nV/sqrt(Hz)")
    ((1, 0), (0, 1), (0, 0), None)
    """
    angles, turns = (list(pattern.finditer(name)) for pattern in (_ANGLE, _TURNS))
    found = [*angles, *turns]
    if len(found) > 1 or any(one.start() or name.startswith("^", one.end()) for one in found):
        return None
    return len(angles), len(turns)


def _refuse_turns(symbol: str, target: str, value: Fraction) -> None:
    """Raise `UnitError` where a unit counts angle and the one that is wanted counts turns, or the other way round."""
    told = turned(symbol, target)
    if told:
        meant = value / _TURN if told.startswith("angle") else value * _TURN
        raise UnitError(f"{symbol} is {told}", _written(meant, target))


def _written(value: Fraction, target: str) -> str:
    return f'write "{float(value):.10g} {short_unit(target)}"' if abs(value) < _HUGE else ""


def _of_dimension(number: Fraction, symbol: str, target: str) -> str:
    """Return what an unknown unit was meant to be where that is known, and has the dimension that is wanted."""
    wanted = unit(target)
    kelvin = CELSIUS.get(symbol)
    if kelvin is not None and wanted.exponents == unit("K").exponents:
        return f'temperatures are in K: write "{float(number * kelvin[0] + kelvin[1]):.10g} K"'
    words = {name: text for name, text in SAME.items() if re.search(rf"(?<![A-Za-z]){name}(?![A-Za-z0-9])", symbol)}
    own = _POWER.sub(r"\1^\2", symbol)
    for name, text in words.items():
        own = re.sub(rf"(?<![A-Za-z]){name}(?![A-Za-z0-9])", text, own)
    for tried in (own, _STANDARD_GRAVITY.sub(r"\g<1>g0", own)):
        if tried != symbol and _dimension(tried) == wanted.exponents:
            return f'write "{float(number):.10g} {tried}"'
    unknown = next((word for word in re.findall(r"[A-Za-zµμΩ]\w*", symbol) if not is_unit(word) and word != "sqrt"), "")
    if not unknown or power_of_a_unit(unknown):
        return ""
    near = _likeliest(unknown, fitting(symbol, unknown, wanted.exponents))
    if near:
        return f"did you mean {_with(symbol, unknown, near)}?"
    return "" if unknown in ANSWERS else f"give it in {short_unit(target)}"


def fitting(symbol: str, unknown: str, wanted: tuple[Fraction, ...]) -> list[str]:
    """Return the units which make an expression of the dimension that is wanted, in place of an unknown name."""
    bases = [name for name in UNITS if _dimension(_with(symbol, unknown, name)) == wanted]
    return [*bases, *(f"{prefix}{name}" for name in bases if UNITS[name][2] for prefix in _OF_COMMON)]


def _likeliest(word: str, names: list[str]) -> str:
    """Return the name most like a word, capitals counting last; empty where none is like it."""

    def likeness(name: str) -> tuple[float, float]:
        return SequenceMatcher(None, word.lower(), name.lower()).ratio(), SequenceMatcher(None, word, name).ratio()

    best = max(names, key=likeness, default="")
    if not best:
        return ""
    least = _LIKE_OF_SHORT if best[0] == word[0] else _LIKE
    return best if likeness(best)[0] >= least else ""


def _with(symbol: str, unknown: str, name: str) -> str:
    """Return an expression with another name in place of an unknown one."""
    return re.sub(rf"(?<![A-Za-z]){unknown}(?![A-Za-z0-9])", name, symbol)


def _dimension(text: str) -> tuple[Fraction, ...] | None:
    """Return the exponents of a unit, None for an unknown one."""
    try:
        return unit(text).exponents
    except UnitError:
        return None


def _other_dimension(text: str, own: str, target: str) -> str:
    """Return what a quantity of another dimension was probably meant to be."""
    wanted = unit(target).exponents
    in_gravity = _STANDARD_GRAVITY.sub(r"\g<1>g0", own)
    if in_gravity != own and unit(in_gravity).exponents == wanted:
        return f'g is the gram; standard gravity is g0: "{text.replace(own, in_gravity)}"'
    if unit(f"({own})/s").exponents == wanted:
        return f'it is per time: "{text}/s", or "{text}/year"'
    kelvin = CELSIUS.get(own)
    if kelvin is not None and wanted == unit("K").exponents:
        return f'temperatures are in K: write "{float(split_quantity(text)[0] * kelvin[0] + kelvin[1]):.10g} K"'
    return f"give it in {short_unit(target)}"


def split_quantity(text: str, example: str = "V") -> tuple[Fraction, str]:
    """The number of a quantity, exactly, and its unit, empty where it has none.

    >>> split_quantity("1.5 kHz")
    (Fraction(3, 2), 'kHz')
    """
    match = _QUANTITY.fullmatch(text)
    plain = text.replace("\N{MINUS SIGN}", "-")
    if match is None and _QUANTITY.fullmatch(plain[:200]):
        raise UnitError("a minus sign of printed text", f'write a hyphen: "{plain.strip()[:40]}"')
    if match is None or len(text) > 200:
        raise UnitError("not a number followed by a unit", f'write a number and a unit, such as "1.5 {example}"')
    if re.match(r",\d", match["unit"]):
        raise UnitError("a decimal comma", f'write a point: "{text.strip().replace(",", ".", 1)}"')
    try:
        return _number(match["number"]), match["unit"]
    except ZeroDivisionError:
        raise UnitError("a division by zero") from None


def is_quantity(text: str) -> bool:
    """Return whether a text is a number with a unit that is known, or without one.

    >>> is_quantity("100 rad/s"), is_quantity("100 rad/s + 1 Hz")
    (True, False)
    """
    match = _QUANTITY.fullmatch(text)
    return match is not None and is_unit(match["unit"] or "1")


def _number(text: str) -> Fraction:
    mantissa, _, divisor = text.replace("_", "").partition("/")
    _, _, exponent = mantissa.lower().partition("e")
    if exponent and (len(exponent) > 4 or abs(int(exponent)) > 400):
        raise UnitError("an exponent of ten beyond 400")
    return Fraction(mantissa) / (Fraction(divisor) if divisor else 1)
