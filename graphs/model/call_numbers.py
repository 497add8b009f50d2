"""Numbers that a call in Python gives, as how often to try: refused before anything computes with them."""

import math
import numbers
from collections.abc import Mapping
from typing import Any, TypeGuard

from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import ModelError, Problem, shown
from proofmass.graphs.model.limits import LARGEST_SEED

SEED = (0, LARGEST_SEED)  # bounds


def refuse_counts(**given: tuple[object, int, int]) -> None:
    """Raise `ModelError` with each number, by name with its least and largest value, that is no integer or beyond."""
    problems = []
    for key, (value, lowest, highest) in given.items():
        if not (whole(value) and lowest <= value <= highest):
            message = "out of range" if whole(value) else "must be an integer"
            expected = f"{lowest:,} to {highest:,}"
            problems.append(Problem(message=message, key=key, got=shown(value), expected=expected))
    if problems:
        raise ModelError(problems)


def frequencies_of(given: object) -> list[float]:
    """Return a list of frequencies in Hz as floats; raises `ModelError` for anything else."""
    try:
        return [real(value) for value in plain(given)]
    except TypeError:
        hint = "write frequencies=[1.0, 10.0], in Hz"
        raise Problem(
            message="must be a list of numbers", key="frequencies", got=shown(given), hint=hint
        ).error from None


def plain_tables(given: Any) -> Any:
    """Return tables and lists, however deep, with numbers and arrays of NumPy as Python has them."""
    value = plain(given)
    if isinstance(value, Mapping):
        return {key: plain_tables(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(map(plain_tables, value))
    return value


def whole(value: object) -> TypeGuard[int]:
    """Return whether a value is an integer, NumPy's too, and no truth value."""
    return isinstance(value, numbers.Integral) and not isinstance(value, bool)


def real(value: object) -> float:
    """Return a number, NumPy's too, as a float; raises `TypeError` for anything else, and for truth values."""
    own = plain(value)
    if isinstance(own, bool) or not isinstance(own, numbers.Real):
        raise TypeError("not a number")
    try:
        return float(own)
    except OverflowError:
        raise TypeError("too large for a float") from None


def positive(value: object) -> bool:
    """Return whether a value is a number that is finite and above 0."""
    try:
        return 0.0 < real(value) < math.inf
    except TypeError:
        return False
