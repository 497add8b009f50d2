"""Unit expressions: seven exponents of the SI base units and an exact factor.

Syntax: names with an optional SI prefix, `*` or a space for product, `/`, `^` with an integer or a fraction,
`sqrt( )` and parentheses, as in `kg*m^2`, `N m s/rad`, `nV/sqrt(Hz)`. Angles are dimensionless, as in the SI.
"""

import math
import re
from difflib import SequenceMatcher
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from proofmass.blocks.declaration.problem import Refusal, did_you_mean
from proofmass.blocks.declaration.unit_words import ANSWERS, CELSIUS, COMMON, SAME, WRITTEN_OUT

BASE = ("m", "kg", "s", "A", "K", "mol", "cd")

PREFIXES = {
    "Y": 24, "Z": 21, "E": 18, "P": 15, "T": 12, "G": 9, "M": 6, "k": 3, "h": 2, "da": 1, "d": -1, "c": -2, "m": -3,
    "u": -6, "µ": -6, "μ": -6, "n": -9, "p": -12, "f": -15, "a": -18, "z": -21, "y": -24,
}  # fmt: skip

_OF_COMMON = ("G", "M", "k", "m", "u", "n", "p", "f")  # prefixes in hints

_LIKE, _LIKE_OF_SHORT = 0.55, 0.5  # least likeness of a name to the one that was meant; with the same first letter

LARGEST_SIZE = 1000  # bits, about 10^300: the factors of all units fit a float

SYNTAX = 'write it as in "kg*m^2/s" or "nV/sqrt(Hz)"'

_PI = Fraction(math.pi)

# name: (factor, exponents of m kg s A K mol cd, takes prefixes)
_UNITS: dict[str, tuple[Fraction, tuple[int, ...], bool]] = {
    "1": (Fraction(1), (), False),
    "m": (Fraction(1), (1,), True),
    "g": (Fraction(1, 1000), (0, 1), True),
    "s": (Fraction(1), (0, 0, 1), True),
    "A": (Fraction(1), (0, 0, 0, 1), True),
    "K": (Fraction(1), (0, 0, 0, 0, 1), True),
    "mol": (Fraction(1), (0, 0, 0, 0, 0, 1), True),
    "cd": (Fraction(1), (0, 0, 0, 0, 0, 0, 1), True),
    "rad": (Fraction(1), (), True),
    "deg": (_PI / 180, (), False),
    "Hz": (Fraction(1), (0, 0, -1), True),
    "N": (Fraction(1), (1, 1, -2), True),
    "Pa": (Fraction(1), (-1, 1, -2), True),
    "bar": (Fraction(100000), (-1, 1, -2), True),
    "J": (Fraction(1), (2, 1, -2), True),
    "eV": (Fraction("1.602176634e-19"), (2, 1, -2), True),
    "W": (Fraction(1), (2, 1, -3), True),
    "C": (Fraction(1), (0, 0, 1, 1), True),
    "V": (Fraction(1), (2, 1, -3, -1), True),
    "F": (Fraction(1), (-2, -1, 4, 2), True),
    "ohm": (Fraction(1), (2, 1, -3, -2), True),
    "Ω": (Fraction(1), (2, 1, -3, -2), True),
    "S": (Fraction(1), (-2, -1, 3, 2), True),
    "Wb": (Fraction(1), (2, 1, -2, -1), True),
    "T": (Fraction(1), (0, 1, -2, -1), True),
    "H": (Fraction(1), (2, 1, -2, -2), True),
    "min": (Fraction(60), (0, 0, 1), False),
    "h": (Fraction(3600), (0, 0, 1), False),
    "d": (Fraction(86400), (0, 0, 1), False),
    "month": (Fraction(31557600, 12), (0, 0, 1), False),
    "months": (Fraction(31557600, 12), (0, 0, 1), False),  # as ages are printed
    "year": (Fraction(31557600), (0, 0, 1), False),
    "years": (Fraction(31557600), (0, 0, 1), False),
    "g0": (Fraction("9.80665"), (1, 0, -2), True),
    "ppm": (Fraction(1, 10**6), (), False),
    "ppb": (Fraction(1, 10**9), (), False),
    "%": (Fraction(1, 100), (), False),
    "bit": (Fraction(1), (), False),
    "LSB": (Fraction(1), (), False),
    "inch": (Fraction(254, 10000), (1,), False),
}

_PRINTED = str.maketrans({"·": "*", "⋅": "*", "×": "*", "²": "^2", "³": "^3", "°": "deg"})
_ROOT = re.compile(r"√\s*(?:\(|(\w+))")
_POWER = re.compile(r"(?<![A-Za-z0-9])([A-Za-zµ]+)([2-6])(?![0-9])")  # as in m/s2
_STANDARD_GRAVITY = re.compile(r"(?<![A-Za-zµμ])([A-Zacdfhkmnpuyzµμ]?)g(?![A-Za-z0-9])")
_TOKEN = re.compile(r"\s*(?:(?P<name>[A-Za-zµμΩ%][A-Za-zµμΩ0-9]*)|(?P<number>[0-9]+(?:\.[0-9]+)?)|(?P<mark>[*/^()+-]))")
_SIMPLE_BRACKET = re.compile(r"(?<!\w)\((\w+)\)")  # not that of sqrt(Hz)
_FACTOR_OF_ONE = re.compile(r"(?<![\w.^-])1\*|[*/]1(?![\w.^])")
_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(?:[0-9][0-9_]*\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?(?:/[0-9]+)?)\s*(?P<unit>.*?)\s*"
)


class Unit(NamedTuple):
    """A unit as a factor to the coherent SI unit and the exponents of the base units `BASE`."""

    factor: Fraction
    exponents: tuple[Fraction, ...]

    def in_base_units(self) -> str:
        """The dimension written in base units, as in `kg*m/s^2`."""
        up = [_power(name, e) for name, e in zip(BASE, self.exponents, strict=True) if e > 0]
        down = [_power(name, -e) for name, e in zip(BASE, self.exponents, strict=True) if e < 0]
        return "*".join(up or ["1"]) + "".join("/" + name for name in down)


class UnitError(Refusal):
    """A unit expression that cannot be read, or a quantity of the wrong dimension."""


@lru_cache(maxsize=4096)
def unit(expression: str) -> Unit:
    """The unit of an expression.

    >>> unit("N").exponents == unit("kg*m/s^2").exponents
    True
    >>> unit("mV").factor
    Fraction(1, 1000)
    """
    if len(expression) > 200:
        raise UnitError("a unit of over 200 characters")
    tokens = _tokens(_ROOT.sub(_plain_root, expression).translate(_PRINTED))
    result, rest = _product(tokens, 0)
    if rest != len(tokens):
        raise UnitError(f"cannot read the unit {expression!r} at {tokens[rest]!r}", SYNTAX)
    return result


def _plain_root(found: "re.Match[str]") -> str:
    """Return a root sign as the function that it stands for."""
    return f"sqrt({found[1]})" if found[1] else "sqrt("


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
    return next((name for name, (factor, own, _) in _UNITS.items() if factor == 1 and _padded(own) == wanted), "")


def convert(text: str, target: str) -> float:
    """The number, in the unit `target`, of a quantity such as `"50 kHz"`.

    The decimal is read exactly and rounded once, so `"50.43e-9 kg"` is the same float as `50.43e-9`.

    >>> convert("50 uN", "N")
    5e-05
    """
    try:
        return float(convert_exactly(text, target))
    except OverflowError:
        raise UnitError("too large for a number") from None


@lru_cache(4096)  # graphs repeat their quantities, and a file is often read again
def convert_exactly(text: str, target: str) -> Fraction:
    """Convert without rounding; rates are kept like this."""
    number, symbol = split_quantity(text, target)
    if not symbol:
        return number
    target_unit = unit(target)
    try:
        source_unit = unit(symbol)
    except UnitError as error:
        meant = _of_dimension(number, symbol, target) if str(error).startswith("unknown unit") else ""
        raise UnitError(str(error), meant or error.hint) from None
    if source_unit.exponents != target_unit.exponents:
        message = f"{symbol} is {source_unit.in_base_units()}, not {target_unit.in_base_units()}"
        raise UnitError(message, _other_dimension(text, symbol, target))
    return number * source_unit.factor / target_unit.factor


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
            return f'write "{_decimal(number)} {tried}"'
    unknown = next((word for word in re.findall(r"[A-Za-zµμΩ]\w*", symbol) if not is_unit(word) and word != "sqrt"), "")
    if not unknown or _power_of_a_unit(unknown):
        return ""
    near = _likeliest(unknown, fitting(symbol, unknown, wanted.exponents))
    if near:
        return f"did you mean {_with(symbol, unknown, near)}?"
    return "" if unknown in ANSWERS else f"give it in {short_unit(target)}"


def fitting(symbol: str, unknown: str, wanted: tuple[Fraction, ...]) -> list[str]:
    """Return the units which make an expression of the dimension that is wanted, in place of an unknown name."""
    bases = [name for name in _UNITS if _dimension(_with(symbol, unknown, name)) == wanted]
    return [*bases, *(f"{prefix}{name}" for name in bases if _UNITS[name][2] for prefix in _OF_COMMON)]


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


def _decimal(number: Fraction) -> str:
    return f"{float(number):.10g}"


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
    if match is None or len(text) > 200:
        raise UnitError("not a number followed by a unit", f'write a number and a unit, such as "1.5 {example}"')
    if re.match(r",\d", match["unit"]):
        raise UnitError("a decimal comma", f'write a point: "{text.strip().replace(",", ".", 1)}"')
    try:
        return _number(match["number"]), match["unit"]
    except ZeroDivisionError:
        raise UnitError("a division by zero") from None


def _number(text: str) -> Fraction:
    mantissa, _, divisor = text.replace("_", "").partition("/")
    _, _, exponent = mantissa.lower().partition("e")
    if len(exponent) > 4 or abs(int(exponent or 0)) > 400:
        raise UnitError("an exponent of ten beyond 400")
    return Fraction(mantissa) / (Fraction(divisor) if divisor else 1)


def _tokens(expression: str) -> list[str]:
    tokens, at = [], 0
    while expression[at:].strip():
        match = _TOKEN.match(expression, at)
        if match is None:
            raise UnitError(f"cannot read the unit {expression!r} at {expression[at:].strip()!r}", SYNTAX)
        tokens.append(match[0].strip())
        at = match.end()
    if not tokens:
        raise UnitError("an empty unit", 'write "1" for a plain number')
    return tokens


def _product(tokens: list[str], at: int) -> tuple[Unit, int]:
    result, at = _factor(tokens, at)
    while at < len(tokens) and tokens[at] != ")":
        sign = 1
        if tokens[at] in "*/":
            sign = -1 if tokens[at] == "/" else 1
            at += 1
        right, at = _factor(tokens, at)
        result = _bounded(
            result.factor * right.factor**sign,
            tuple(a + sign * b for a, b in zip(result.exponents, right.exponents, strict=True)),
        )
    return result, at


def _factor(tokens: list[str], at: int) -> tuple[Unit, int]:
    if at >= len(tokens):
        raise UnitError("the unit ends too early", SYNTAX)
    token = tokens[at]
    if token in "*/^)+-":
        raise UnitError(f"a unit is missing before {token!r}", SYNTAX)
    if token == "sqrt" and at + 1 < len(tokens) and tokens[at + 1] == "(":
        inner, at = _bracket(tokens, at + 1)
        result = _raise(inner, Fraction(1, 2))
    elif token == "(":
        result, at = _bracket(tokens, at)
    else:
        result, at = _named(token), at + 1
    if at < len(tokens) and tokens[at] == "^":
        exponent, at = _exponent(tokens, at + 1)
        result = _raise(result, exponent)
    return result, at


def _bracket(tokens: list[str], at: int) -> tuple[Unit, int]:
    if tokens.count("(") > 16:
        raise UnitError("a unit with over 16 brackets")
    inner, at = _product(tokens, at + 1)
    if at >= len(tokens):
        raise UnitError("a bracket is not closed")
    return inner, at + 1


def _exponent(tokens: list[str], at: int) -> tuple[Fraction, int]:
    sign = 1
    if at < len(tokens) and tokens[at] in "+-":
        sign = -1 if tokens[at] == "-" else 1
        at += 1
    if at >= len(tokens) or not tokens[at][0].isdigit() or len(tokens[at]) > 6:
        raise UnitError("an exponent must be a number such as 2, -1 or 0.5")
    return sign * Fraction(tokens[at]), at + 1


def _raise(base: Unit, exponent: Fraction) -> Unit:
    if abs(exponent) > 12:
        raise UnitError("an exponent beyond 12")
    size = base.factor.numerator.bit_length() - base.factor.denominator.bit_length()
    if abs(size * exponent) > LARGEST_SIZE:
        raise UnitError("a unit beyond 10^300")
    factor = base.factor ** int(exponent) if exponent.denominator == 1 else _rational_power(base.factor, exponent)
    return _bounded(factor, tuple(e * exponent for e in base.exponents))


def _bounded(factor: Fraction, exponents: tuple[Fraction, ...]) -> Unit:
    """A unit whose numbers stay small: nested powers could make them fill the memory."""
    up, down = factor.numerator.bit_length(), factor.denominator.bit_length()
    if abs(up - down) > LARGEST_SIZE or up + down > 8 * LARGEST_SIZE:
        raise UnitError("a unit beyond 10^300")
    if any(abs(e) > 1000 or e.denominator > 1000 for e in exponents):
        raise UnitError("a dimension with an exponent beyond 1000")
    return Unit(factor, exponents)


def _rational_power(base: Fraction, exponent: Fraction) -> Fraction:
    """Exact where the root is rational (sqrt(kHz^2)), the nearest float otherwise (sqrt(kHz))."""
    if exponent.denominator <= 12:
        up, down = (_whole_root(n, exponent.denominator) for n in base.as_integer_ratio())
        if up and down:
            return Fraction(up, down) ** exponent.numerator
    return Fraction(float(base) ** float(exponent))


def _whole_root(number: int, degree: int) -> int:
    """The root of a positive whole number by Newton's iteration; 0 where it is not whole."""
    root = 1 << -(-number.bit_length() // degree)
    while (lower := ((degree - 1) * root + number // root ** (degree - 1)) // degree) < root:
        root = lower
    return root if root**degree == number else 0


@lru_cache(maxsize=4096)
def _named(name: str) -> Unit:
    if name in _UNITS:
        factor, exponents, _ = _UNITS[name]
        return Unit(factor, _padded(exponents))
    for prefix, ten in PREFIXES.items():
        base = _UNITS.get(name[len(prefix) :]) if name.startswith(prefix) else None
        if base is not None and base[2]:
            return Unit(base[0] * Fraction(10) ** ten, _padded(base[1]))
    raise UnitError(f"unknown unit {name!r}", _like(name))


def _like(name: str) -> str:
    if name in ANSWERS:
        return ANSWERS[name]
    if letters := _power_of_a_unit(name):
        return f"write a power as {letters}^{name[len(letters) :]}"
    word = name.lower().removesuffix("s")
    if word in WRITTEN_OUT:
        return f"did you mean {WRITTEN_OUT[word]}?"
    return did_you_mean(name[:20], (*_UNITS, *COMMON), "units")


def _power_of_a_unit(name: str) -> str:
    """Return the unit of which a name with digits is a power, as of s2; empty for g00, a zero behind g0."""
    letters = name.rstrip("0123456789")
    return letters if letters != name and name[len(letters)] != "0" and is_unit(letters) else ""


def is_unit(expression: str) -> bool:
    """Return whether a text is a unit that is known."""
    try:
        unit(expression)
    except UnitError:
        return False
    return True


def _padded(exponents: tuple[int, ...]) -> tuple[Fraction, ...]:
    return tuple(Fraction(e) for e in exponents + (0,) * (len(BASE) - len(exponents)))


def _power(name: str, exponent: Fraction) -> str:
    return name if exponent == 1 else f"{name}^{exponent}"
