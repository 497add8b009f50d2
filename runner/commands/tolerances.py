"""Tolerances as options give them."""

from typing import Any

import click


def read_tolerance(text: str) -> tuple[str, Any]:
    """Return the parameter and the width of an option such as `pid.integral=5 %` or `adc.reference=4.9 V..5.2 V`."""
    name, equals, width = text.partition("=")
    if not (equals and name.strip() and width.strip()):
        raise click.UsageError(f'--tolerance {text}: write BLOCK.PARAMETER="5 %", or a width with a unit')
    low, dots, high = width.partition("..")
    return name.strip(), [low.strip(), high.strip()] if dots else width.strip()
