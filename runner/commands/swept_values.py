"""The values of `--sweep`: lists, and ranges in equal or logarithmic steps."""

import re
import tomllib
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import click

from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.units import convert, convert_exactly, split_quantity
from proofmass.graphs.files.toml_reader import held_float

MOST = 10_000  # values of a range
_WIDEST = Fraction(10**300)  # between the ends of logarithmic steps: a ratio is a float
_RANGE = re.compile(r"\s*([^:]+):([^:]+):\s*(\d{1,9})\s*(:\s*log\s*)?")


def sweeps(texts: tuple[str, ...]) -> dict[str, list[object]]:
    """Return the values of each `--sweep`; raises `click.UsageError`."""
    lists: dict[str, list[object]] = {}
    for text in texts:
        key, equals, values = (part.strip() for part in text.partition("="))
        if not equals or not values:
            raise click.UsageError(f"--sweep {text}: write NAME=VALUE,VALUE, for example adc.bits=10,12,14")
        if key in lists:
            raise click.UsageError(f"--sweep {key} is given twice: write all its values in one list")
        lists[key] = [value for part in values.split(",") for value in _values(part, text)]
    return lists


def value_of(text: str) -> Any:
    """Return a number or true or false, or else the text itself, as a quantity without quotes."""
    try:
        return tomllib.loads(f"value = {text}", parse_float=held_float)["value"]
    except (ValueError, RecursionError):
        return text.strip()


def _values(part: str, text: str) -> list[Any]:
    """Return a list entry's value, or those of a range FROM:TO:COUNT or FROM:TO:COUNT:log."""
    found = _RANGE.fullmatch(part)
    if found is None:
        return [value_of(part)]
    try:
        first, unit = split_quantity(found[1].strip())
        last, count = convert_exactly(found[2].strip(), unit or "1"), int(found[3])
        for end in found.group(1, 2):
            convert(end.strip(), unit or "1")  # refuses what a float does not hold
    except Refusal as error:
        raise click.UsageError(f"--sweep {text}: {error}") from None
    if not 2 <= count <= MOST:
        raise click.UsageError(f"--sweep {text}: a range has 2 to {MOST} values, not {count}")
    if found[4] and first * last <= 0:
        raise click.UsageError(f"--sweep {text}: logarithmic steps need two ends above zero, or two below")
    if found[4] and not _WIDEST**-1 < last / first < _WIDEST:
        raise click.UsageError(f"--sweep {text}: logarithmic steps over more than 300 decades")
    steps = _powers(first, last, count) if found[4] else _steps(first, last, count)
    return [f"{float(value)!r} {unit}" if unit else _number(value) for value in steps]


def _steps(first: Fraction, last: Fraction, count: int) -> Iterator[Fraction]:
    for number in range(count):
        yield first + (last - first) * number / (count - 1)


def _powers(first: Fraction, last: Fraction, count: int) -> Iterator[Fraction]:
    for number in range(count - 1):
        yield first * Fraction(f"{float(last / first) ** (number / (count - 1)):.15g}")
    yield last


def _number(value: Fraction) -> int | float:
    return value.numerator if value.denominator == 1 else float(value)
