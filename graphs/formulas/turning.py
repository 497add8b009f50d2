"""Angle and turns in formulas: rad/s and Hz are one dimension, and the units in a formula tell them apart.

Turning is counted in exponents of angle and of turns, as dimensions are. A turn is 2 pi rad, which no ratio of
whole numbers is: a factor that is whole leaves the turning as it is, and with any other number, as pi or 6.28, a
formula may well convert.
"""

import operator
from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.blocks.declaration.units import turning_of_unit
from proofmass.graphs.formulas.operations import CONSTANTS, NUMBER, Dimension, coherent_unit
from proofmass.graphs.formulas.tree import Apply, Name, Number, Raised, Tree, fixed


class Turning(NamedTuple):
    """Exponents of angle and of turns."""

    angle: Fraction
    turns: Fraction


STILL = Turning(Fraction(0), Fraction(0))
ANGLE, TURNS = STILL._replace(angle=Fraction(1)), STILL._replace(turns=Fraction(1))
_ALIKE = ("+", "-", "min", "max", "hypot", "abs", "negative")  # operations whose result counts what their arguments do


def counted_unit(turning: Turning | None, dimension: Dimension) -> str:
    """Return the coherent unit of a dimension, in angle or turns where these are counted a second."""
    counted = {ANGLE: "rad/s", TURNS: "Hz"}.get(turning or STILL)
    return counted if counted and dimension == unit("Hz").exponents else coherent_unit(dimension)


def turning_of(tree: Tree, of_value: Callable[[str], "Turning | None"]) -> Turning | None:
    """Return the turning of a tree, None where it may convert; raises `Refusal` for a sum of angle and turns.

    `of_value` gives that of a named value, and raises `KeyError` for a name that is none.
    """
    match tree:
        case Number(value, dimension, written):
            return turning_of_quantity(value, dimension, written)
        case Name(name):
            try:
                return of_value(name)
            except KeyError:
                return None if name in CONSTANTS else turning_of_quantity(1.0, fixed(name).dimension, name)
        case Raised(base, exponent):
            return _scaled(turning_of(base, of_value), Fraction(exponent))
        case Apply(operation, arguments):
            known = [turning_of(argument, of_value) for argument in arguments]
            return _applied(operation, known)


def turning_of_quantity(value: float, dimension: Dimension, written: str) -> Turning | None:
    """Return the turning of a number in coherent units that was written in a unit."""
    counted = turning_of_unit(written)
    if counted is None or (not any(counted) and dimension == NUMBER and not value.is_integer()):
        return None
    return Turning(*map(Fraction, counted))


def _applied(operation: str, known: list[Turning | None]) -> Turning | None:
    if operation == "sqrt":
        return _scaled(known[0], Fraction(1, 2))
    arguments = [turning for turning in known if turning is not None]
    if len(arguments) < len(known) or operation not in ("*", "/", *_ALIKE):
        return None
    if operation in ("*", "/"):
        combined = operator.add if operation == "*" else operator.sub
        return Turning(*map(combined, *arguments))
    moving = {turning for turning in arguments if turning != STILL}
    if moving == {ANGLE, TURNS}:
        raise Refusal(
            "a sum takes angle and turns a second", "multiply what is in Hz by 2 * pi, or divide what is in rad/s by it"
        )
    return moving.pop() if len(moving) == 1 else None if moving else STILL


def _scaled(turning: Turning | None, exponent: Fraction) -> Turning | None:
    return None if turning is None else Turning(turning.angle * exponent, turning.turns * exponent)
