"""What a block answers to a signal, and how near two signals are to each other."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from proofmass.blocks.declaration.declare import Block
from tests.by_hand.functions import drive


def response(
    block: Block, signal: Iterable[Any], output: str = "output", input: str = "input", period: float = 1.0
) -> list[Any]:
    """One output of a block with one input, tick by tick."""
    return [row[output] for row in drive(block, [{input: value} for value in signal], period)]


def responses(block: Block, output: str = "output", period: float = 1.0, **signals: Sequence[Any]) -> list[Any]:
    """One output of a block with several inputs, tick by tick."""
    rows = [dict(zip(signals, values, strict=True)) for values in zip(*signals.values(), strict=True)]
    return [row[output] for row in drive(block, rows, period)]


def distance(values: Any, expected: Any) -> float:
    """The largest difference of two signals over the largest value of the expected one."""
    return float(np.max(np.abs(np.asarray(values) - np.asarray(expected))) / np.max(np.abs(expected)))


def noise(samples: int, seed: int = 1, size: float = 1.0) -> list[float]:
    """Normal deviates."""
    values: list[float] = (size * np.random.default_rng(seed).normal(size=samples)).tolist()
    return values
