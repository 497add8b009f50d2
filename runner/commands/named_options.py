"""Options that say something of a name, such as tolerances."""

from collections import Counter
from collections.abc import Iterable
from typing import Any, TypeVar

import click

_Said = TypeVar("_Said")


def by_name(option: str, pairs: Iterable[tuple[str, _Said]]) -> dict[str, _Said]:
    """Return what is said by name; raises `click.UsageError` where two say something of one."""
    said = list(pairs)
    twice = sorted(name for name, times in Counter(name for name, _ in said).items() if times > 1)
    if twice:
        raise click.UsageError(f"{f'{option} {twice[0]}'.rstrip()} is given twice: keep one of them")
    return dict(said)


def read_tolerance(text: str) -> tuple[str, Any]:
    """Return the parameter and the width of an option such as `pid.integral=5 %` or `adc.reference=4.9 V..5.2 V`."""
    name, equals, width = text.partition("=")
    if not (equals and name.strip() and width.strip()):
        raise click.UsageError(f'--tolerance {text}: write BLOCK.PARAMETER="5 %", or a width with a unit')
    low, dots, high = width.partition("..")
    return name.strip(), [low.strip(), high.strip()] if dots else width.strip()
