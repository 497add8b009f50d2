"""Blocks with parameters drawn by chance."""

import math
import random
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import ModelError


def random_block(kind: type[Block], dice: random.Random, folder: Path) -> Block:
    """The block with parameters drawn about their defaults, within their bounds.

    Where all drawn at once never go together, half of them keep their defaults.
    """
    fixed = _recording(folder) if any(buffer.recorded for buffer in kind.buffers.values()) else {}
    for attempt in range(100):
        values = {n: random_value(p, dice) for n, p in kind.parameters.items() if attempt < 50 or dice.random() < 0.5}
        try:
            return kind(**(values | fixed))
        except ModelError:
            continue
    return kind(**fixed)


def random_value(parameter: Parameter, dice: random.Random) -> Any:
    """A number about the default of a parameter, within its bounds; any of its choices."""
    default = parameter.default
    if parameter.kind is bool:
        return dice.random() < 0.5
    if parameter.choices:
        return dice.choice(parameter.choices)
    if parameter.kind is not float:
        return default
    value = default * math.exp(dice.gauss(0.0, 0.3)) if default else dice.uniform(-0.5, 0.5)
    for bound in (parameter.at_least, parameter.above):
        value = max(value, bound) if bound is not None else value
    for bound in (parameter.at_most, parameter.below):
        value = min(value, bound) if bound is not None else value
    return value


def _recording(folder: Path) -> dict[str, str]:
    rows = (f"{0.0037 * n!r},{math.sin(0.9 * n)!r}" for n in range(250))
    (folder / "recording.csv").write_text("\n".join(["time [s],signal", *rows]) + "\n")
    return {"file": "recording.csv"}
