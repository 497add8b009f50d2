"""The reader of unit expressions: seven exponents of the SI base units and an exact factor.

Syntax: names with an optional SI prefix, `*` or a space for product, `/`, `^` with an integer or a
fraction, `sqrt( )` and parentheses, as in `kg*m^2`, `N m s/rad`, `nV/sqrt(Hz)`. Angles are
dimensionless, as in the SI.
"""

import math
import re
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from proofmass.blocks.declaration.problem import Refusal, did_you_mean
from proofmass.blocks.declaration.unit_words import ANSWERS, COMMON, WRITTEN_OUT

BASE = ("m", "kg", "s", "A", "K", "mol", "cd")

PREFIXES = {
    "Y": 24, "Z": 21, "E": 18, "P": 15, "T": 12, "G": 9, "M": 6, "k": 3, "h": 2, "da": 1, "d": -1, "c": -2, "m": -3,
    "u": -6, "µ": -6, "μ": -6, "n": -9, "p": -12, "f": -15, "a": -18, "z": -21, "y": -24,
}  # fmt: skip

LARGEST_SIZE = 1000  # bits, about 10^300: the factors of all units fit a float

SYNTAX = 'write it as in "kg*m^2/s" or "nV/sqrt(Hz)"'

_PI = Fraction(math.pi)

# name: (factor, exponents of m kg s A K mol cd, takes prefixes)
UNITS: dict[str, tuple[Fraction, tuple[int, ...], bool]] = {
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

_PRINTED = str.maketrans({"·": "*", "⋅": "*", "×": "*", "°": "deg"})
_RAISED = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")
_POWER = re.compile(r"[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_ROOT = re.compile(r"√\s*(?:\(|(\w+))")
_TOKEN = re.compile(r"\s*(?:(?P<name>[A-Za-zµμΩ%][A-Za-zµμΩ0-9]*)|(?P<number>[0-9]+(?:\.[0-9]+)?)|(?P<mark>[*/^()+-]))")


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
    tokens = _tokens(typed(expression))
    result, rest = _product(tokens, 0)
    if rest != len(tokens):
        raise UnitError(f"cannot read the unit {expression!r} at {tokens[rest]!r}", SYNTAX)
    return result


def typed(text: str) -> str:
    """Return a unit or a formula as it is typed: printed signs of products, powers, roots and degrees in ASCII.

    >>> typed("m·s⁻²/V"), typed("µg0/√Hz")
    ('m*s^-2 /V', 'µg0/sqrt(Hz)')
    """
    powers = _POWER.sub(lambda power: f"^{power[0].translate(_RAISED)} ", text)
    return _ROOT.sub(_plain_root, powers).translate(_PRINTED)


def _plain_root(found: "re.Match[str]") -> str:
    """Return a root sign as the function that it stands for."""
    return f"sqrt({found[1]})" if found[1] else "sqrt("


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


def _named(name: str) -> Unit:
    known = _known(name)
    if known is None:
        raise UnitError(f"unknown unit {name!r}", _like(name))
    return known


@lru_cache(maxsize=4096)
def _known(name: str) -> Unit | None:
    if name in UNITS:
        factor, exponents, _ = UNITS[name]
        return Unit(factor, padded(exponents))
    for prefix, ten in PREFIXES.items():
        base = UNITS.get(name[len(prefix) :]) if name.startswith(prefix) else None
        if base is not None and base[2]:
            return Unit(base[0] * Fraction(10) ** ten, padded(base[1]))
    return None


def _like(name: str) -> str:
    if name in ANSWERS:
        return ANSWERS[name]
    if letters := power_of_a_unit(name):
        return f"write a power as {letters}^{name[len(letters) :]}"
    word = name.lower().removesuffix("s")
    if word in WRITTEN_OUT:
        return f"did you mean {WRITTEN_OUT[word]}?"
    return did_you_mean(name[:20], (*UNITS, *COMMON), "units")


def power_of_a_unit(name: str) -> str:
    """Return the unit of which a name with digits is a power, as s2; empty for g00."""
    letters = name.rstrip("0123456789")
    return letters if letters != name and name[len(letters)] != "0" and is_unit(letters) else ""


def is_unit(expression: str) -> bool:
    """Return whether a text is a unit that is known."""
    if expression.isascii() and expression.isidentifier():
        return _known(expression) is not None  # a name, as of a value: what it may have meant is not looked for
    try:
        unit(expression)
    except UnitError:
        return False
    return True


def padded(exponents: tuple[int, ...]) -> tuple[Fraction, ...]:
    return tuple(Fraction(e) for e in exponents + (0,) * (len(BASE) - len(exponents)))


def _power(name: str, exponent: Fraction) -> str:
    return name if exponent == 1 else f"{name}^{exponent}"
