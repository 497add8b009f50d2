"""Magnitude of a pair: output = sqrt(first^2 + second^2)."""

import math

from proofmass.blocks.declaration.declare import Block, Input, param


class Magnitude(Block):
    """Length of a vector of two or three components: the amplitude of an I/Q pair, the size of an acceleration."""

    unit: str = param("", "Unit of inputs and output.", default="1")

    first = Input("{unit}", "First component.")
    second = Input("{unit}", "Second component.")
    third = Input("{unit}", "Third component.", default=0.0)


@Magnitude.output("{unit}")
def output(p: Magnitude, first: float, second: float, third: float) -> float:
    """The length."""
    return math.sqrt(first * first + second * second + third * third)
