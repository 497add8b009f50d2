"""Drive one digital block by hand, on mantissas, and casts in the language of fractions to hold it against."""

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction

import numpy as np

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.fixed.digital import digital_block
from tests.by_hand.integer_code import Code

ROUNDINGS = ("half_even", "half_up", "floor", "toward_zero")


def drive_fixed(block: Block, samples: Iterable[Mapping[str, int]], period: float = 1.0) -> list[dict[str, int]]:
    """Mantissas of the outputs in each tick, by the integer code; the reference must agree in every tick."""
    made = digital_block("block", block, period)
    codes = {name: Code(step.code) for name, step in made.steps.items()}
    known = {name: [list(held), list(held)] for name, held in made.buffers.items()}
    state = made.start
    rows = []
    for tick, inputs in enumerate(samples):
        row = {}
        for name, behaviour in _functions(block).items():
            step = made.steps[name]
            values = dict(inputs) | {"p": None, "x": state, "tick": tick}
            results = []
            for i, call in enumerate((step.reference, codes[name])):
                arguments = [known[a][i] if a in known else values[a] for a in behaviour.arguments]
                results.append(call(made.constants if i else None, *arguments))
            result = results[1][0] if step.overflows or step.refuses else results[1]
            assert results[0] == result, f"{name} in tick {tick}"
            assert all(first == second for first, second in known.values())
            if name == "update":
                state = result
            else:
                row[name] = result
        rows.append(row)
    return rows


def _functions(block: Block) -> dict[str, Behaviour]:
    """Outputs, then the update, as in a tick."""
    update = {"update": type(block).functions["update"]} if "update" in type(block).functions else {}
    return dict(type(block).output_functions) | update


def cast(value: Fraction, target: Fixed, rounding: str, overflow: str) -> int:
    """The mantissa of a value in a format."""
    steps = value * Fraction(2) ** target.fraction
    if rounding == "half_even":
        mantissa = round(steps)
    elif rounding == "half_up":
        mantissa = math.floor(steps + Fraction(1, 2))
    else:
        mantissa = math.floor(steps) if rounding == "floor" else math.trunc(steps)
    if overflow == "wrap":
        return (mantissa - target.lowest) % (1 << target.width) + target.lowest
    return min(max(mantissa, target.lowest), target.highest)


def value_of(mantissa: int, format: Fixed) -> Fraction:
    """The number that a register holds."""
    return mantissa * Fraction(2) ** -format.fraction


def words(format: Fixed, count: int, seed: int = 1) -> list[int]:
    """Mantissas at random, the ends of the range more often than others."""
    rng = np.random.default_rng(seed)
    drawn = rng.integers(format.lowest, format.highest, count, endpoint=True)
    drawn[::17], drawn[5::23] = format.lowest, format.highest
    found: list[int] = drawn.tolist()
    return found
