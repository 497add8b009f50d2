"""A formula: its text, such as `"= 2 * pi * f0"`, and its meaning."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeGuard

from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.graphs.formulas.operations import NUMBER, Dimension, dimension_text
from proofmass.graphs.formulas.parser import parsed
from proofmass.graphs.formulas.tree import Numbers, Tree, dimension_of, evaluated, names_of, plainly

SIGN = "="


def is_formula(value: object) -> TypeGuard[str]:
    """Return whether a person wrote a formula."""
    return isinstance(value, str) and value.lstrip().startswith(SIGN)


@dataclass(frozen=True)
class Formula:
    """A formula as written; raises `Refusal` for a text that is not a formula."""

    text: str
    unit: str = ""  # in which tables show the measure that it gives, such as "deg/h"; its value is in that of its terms

    def __post_init__(self) -> None:
        parsed(self._body)

    @property
    def _body(self) -> str:
        return self.text.strip().removeprefix(SIGN).strip()

    @property
    def tree(self) -> Tree:
        """The formula as a tree."""
        return parsed(self._body)

    @property
    def names(self) -> frozenset[str]:
        """Names in it: values, and constants and units too."""
        return names_of(self.tree)

    def number(self, numbers: Numbers) -> float:
        """Return the value in coherent SI units; raises `Refusal` where there is none."""
        value = float(evaluated(self.tree, numbers, _kept))
        if value - value != 0.0:
            hint = "look for a division by zero, a root or logarithm of a negative number"
            raise Refusal("has no finite value", hint)
        return value

    def quantity(self, numbers: Numbers, dimensions: Mapping[str, Dimension], target: str) -> float:
        """Return the value in a unit; raises `Refusal` where it has another dimension."""
        own, wanted = dimension_of(self.tree, dimensions), unit(target)
        if own != wanted.exponents:
            raise Refusal(f"is {dimension_text(own)}, not {dimension_text(wanted.exponents)}", _cure(own, target))
        return in_unit(self.number(numbers), target)


def in_unit(number: float, target: str) -> float:
    """Return a number of coherent SI units in another unit; numbers may be arrays."""
    factor = unit(target).factor
    return number if factor == 1 else number / float(factor)


def _kept(operation: str, arguments: list[float]) -> float:
    """Return the result of an operation; raises `Refusal` for a product or quotient that is lost, or its digits."""
    value: float = plainly(operation, arguments)
    if operation in ("*", "/") and abs(value) < sys.float_info.min and all(arguments):
        hint = f"a product or quotient in it is below {sys.float_info.min:.2g}: multiply in another order"
        raise Refusal("too small for a number", hint)
    return value


def _cure(own: Dimension, target: str) -> str:
    if own == NUMBER:
        return f"give its numbers units, as in 1.5 {target}"
    return f"the result must be {'in ' + target if target != '1' else 'a plain number'}"
