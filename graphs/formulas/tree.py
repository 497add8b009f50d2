"""Formulas as trees: numbers, names and operations; their value, dimension and derivatives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from proofmass.blocks.declaration.problem import Refusal, did_you_mean, shown
from proofmass.blocks.declaration.unit_expressions import UnitError, unit
from proofmass.graphs.formulas.operations import CONSTANTS, FUNCTIONS, NUMBER, OPERATIONS, Dimension, multiplied

LARGEST_WHOLE_POWER = 64  # multiplied out
_FINEST_ROOT = 12  # of a quantity with a unit


@dataclass(frozen=True)
class Number:
    """A number in coherent SI units."""

    value: float
    dimension: Dimension = NUMBER
    unit: str = "1"  # in which it is written


@dataclass(frozen=True)
class Name:
    """A value, a constant, or a unit."""

    name: str


@dataclass(frozen=True)
class Apply:
    """An operation on its arguments."""

    operation: str
    arguments: "tuple[Tree, ...]"


@dataclass(frozen=True)
class Raised:
    """A whole power, which is multiplied out."""

    base: "Tree"
    exponent: int


Tree = Number | Name | Apply | Raised
Numbers = Mapping[str, Any]  # values by name, in coherent SI units: numbers, or arrays of them


def names_of(tree: Tree) -> frozenset[str]:
    """Return the names that a tree holds, those of constants and units included."""
    match tree:
        case Name(name):
            return frozenset({name})
        case Apply(_, arguments):
            return frozenset[str]().union(*map(names_of, arguments))
        case Raised(base, _):
            return names_of(base)
        case Number():
            return frozenset()


def plainly(operation: str, arguments: list[Any]) -> Any:
    """Return the result of an operation on plain numbers."""
    return OPERATIONS[operation].function(*arguments)


def evaluated(tree: Tree, numbers: Numbers, apply: Callable[[str, list[Any]], Any] = plainly) -> Any:
    """Return the value of a tree; `apply` says what operations do, for non-floats."""
    match tree:
        case Number(value):
            return value
        case Name(name):
            return numbers[name] if name in numbers else fixed(name).value
        case Apply(operation, arguments):
            return apply(operation, [evaluated(argument, numbers, apply) for argument in arguments])
        case Raised(base, exponent):
            power = _multiplied_out(evaluated(base, numbers, apply), abs(exponent), apply)
            return power if exponent >= 0 else apply("/", [1.0, power])


def slopes(tree: Tree, numbers: Numbers) -> dict[str, float]:
    """Return the exact derivative of a tree by each value in it."""
    match tree:
        case Name(name):
            return {name: 1.0} if name in numbers else {}
        case Apply(operation, arguments):
            at = [evaluated(argument, numbers) for argument in arguments]
            parts = OPERATIONS[operation].slopes(*at)
            return _chained(zip(parts, (slopes(argument, numbers) for argument in arguments), strict=True))
        case Raised(base, exponent):
            at = evaluated(Raised(base, exponent - 1), numbers)
            return _chained([(exponent * at, slopes(base, numbers))]) if exponent else {}
        case Number():
            return {}


def dimension_of(tree: Tree, dimensions: Mapping[str, Dimension]) -> Dimension:
    """Return the dimension of a tree; raises `Refusal` where units do not go together or a name is unknown."""
    match tree:
        case Number(_, dimension):
            return dimension
        case Name(name):
            return dimensions[name] if name in dimensions else fixed(name, dimensions).dimension
        case Raised(base, exponent):
            return multiplied(dimension_of(base, dimensions), exponent)
        case Apply("power", (base, exponent)):
            return _power_dimension(base, exponent, dimensions)
        case Apply(operation, arguments):
            return OPERATIONS[operation].dimension(operation, [dimension_of(a, dimensions) for a in arguments])


def fixed(name: str, values: Mapping[str, Any] | None = None) -> Number:
    """Return the number of a constant or a unit; raises `Refusal` for a name that is neither, nor one of the values."""
    if name in CONSTANTS:
        return Number(CONSTANTS[name])
    try:
        unit_named = unit(name)
    except UnitError:
        near = did_you_mean(name, [*(values or ()), *CONSTANTS], "the values")
        hint = f"{near} Otherwise give {name[:60]} a value below [values]"
        if name in FUNCTIONS:
            hint = f"write its argument in brackets: {name}( )"
        raise Refusal(f"there is no value or unit {shown(name, 60)[1:-1]}", hint) from None
    return Number(float(unit_named.factor), unit_named.exponents, name)


def _multiplied_out(base: Any, exponent: int, apply: Callable[[str, list[Any]], Any]) -> Any:
    result, square = None, base
    while exponent:
        if exponent & 1:
            result = square if result is None else apply("*", [result, square])
        exponent >>= 1
        square = apply("*", [square, square]) if exponent else square
    return 1.0 if result is None else result


def _chained(parts: Any) -> dict[str, float]:
    total: dict[str, float] = {}
    for outer, inner in parts:
        for name, slope in inner.items():
            total[name] = total.get(name, 0.0) + outer * slope
    return total


def _power_dimension(base: Tree, exponent: Tree, dimensions: Mapping[str, Dimension]) -> Dimension:
    of_base = dimension_of(base, dimensions)
    if dimension_of(exponent, dimensions) != NUMBER:
        raise Refusal("an exponent must be a plain number")
    if of_base == NUMBER:
        return NUMBER
    if names_of(exponent) - CONSTANTS.keys():
        message = "the exponent of a quantity with a unit must be written as a number"
        raise Refusal(message, "write it as in x^2, x^(1/2)")
    number = evaluated(exponent, {})
    near = Fraction(number).limit_denominator(_FINEST_ROOT) if abs(number) < 1e6 else Fraction(0)
    if abs(float(near) - number) > 1e-12 * abs(number):
        message = "the exponent of a quantity with a unit must be a ratio of small numbers"
        raise Refusal(message, "write it as in x^(3/2)")
    return multiplied(of_base, near)
