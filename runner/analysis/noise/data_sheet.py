"""From the figures of a data sheet to the blocks that make such noise.

N is the coefficient of random walk, a one-sided density sqrt(2) N; B that of bias instability,
whose flat Allan deviation is sqrt(2 ln 2 / pi) B = 0.664 B and whose one-sided density is B^2 / (pi
f); K that of the random walk of the signal.
"""

import math
from collections.abc import Mapping

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert, same_dimension, short_unit, split_quantity
from proofmass.blocks.noise_and_drift.flicker_noise import FlickerNoise
from proofmass.blocks.noise_and_drift.random_walk import RandomWalk
from proofmass.blocks.noise_and_drift.white_noise import WhiteNoise
from proofmass.blocks.signals.gain import Gain
from proofmass.blocks.signals.sum import Sum

FLAT = math.sqrt(2.0 * math.log(2.0) / math.pi)  # of the Allan deviation of flicker noise, by B
_SUFFIX = {"density": "/sqrt(Hz)", "N": "/sqrt(Hz)", "B": "", "K": "/sqrt(s)"}


def noise_blocks_of(
    figures: Mapping[str, str], unit: str = "", *, flat: bool = False, longest: float = 1e4, rate: float = 1e3
) -> tuple[dict[str, Block], list[str]]:
    """Blocks and wires whose sum, `noise.output`, has a white `density` or `N`, flicker `B` and a
    random walk `K`.

    Figures are quantities, "0.1 deg/sqrt(h)"; `unit` is that of the signal. With `flat` B is what
    the Allan deviation comes down to. Flicker noise reaches down to a tenth of one by `longest`, in
    seconds, and up to half the rate.
    """
    if not 0.0 < longest < math.inf:
        raise Problem(message="must be > 0", key="longest", got=f"{longest:g} s").error
    unit = unit or _unit_of(figures)
    numbers = {name: _number(name, text, unit) for name, text in figures.items()}
    if "density" in numbers and "N" in numbers:
        message = "give a density or a random walk, not both: one follows from the other"
        raise Problem(message=message, key="N").error
    blocks: dict[str, Block] = {}
    if "density" in numbers or "N" in numbers:
        blocks["white"] = WhiteNoise(density=numbers.get("density", math.sqrt(2.0) * numbers.get("N", 0.0)), unit=unit)
    if "B" in numbers:
        level = (numbers["B"] / FLAT if flat else numbers["B"]) / math.sqrt(math.pi)
        blocks["flicker"] = FlickerNoise(level=level, lowest_frequency=0.1 / longest, highest_frequency=0.5 * rate)
    if "K" in numbers:
        blocks["wander"] = RandomWalk(coefficient=numbers["K"])
    return _added(blocks, unit)


def _added(blocks: dict[str, Block], unit: str) -> tuple[dict[str, Block], list[str]]:
    """The blocks with what sums them up, and their wires; deviations without unit are given one by a gain of 1."""
    wires, sources = [], []
    for name in tuple(blocks):
        source = f"{name}.output"
        if name != "white":
            blocks[f"{name}_signal"] = Gain(gain=1.0, input_unit="1", output_unit=unit)
            wires.append(f"{name}.deviation -> {name}_signal.input")
            source = f"{name}_signal.output"
        sources.append(source)
    if len(sources) == 1:
        return blocks, wires
    blocks["noise"] = Sum(unit=unit)
    wires += [
        f"{source} -> noise.{entry}" for source, entry in zip(sources, ("first", "second", "third"), strict=False)
    ]
    return blocks, wires


def _unit_of(figures: Mapping[str, str]) -> str:
    """rad/s or m/s^2, whichever the figures are of."""
    for unit in ("rad/s", "m/s^2"):
        if all(_fits(text, short_unit(f"({unit}){_SUFFIX[name]}")) for name, text in figures.items()):
            return unit
    message = "the figures are not all of an angular rate or of an acceleration"
    hint = "say the unit of the signal, as in --unit V"
    raise Problem(message=message, key="unit", got=", ".join(figures.values()), hint=hint).error


def _fits(text: str, unit: str) -> bool:
    """Return whether a quantity may have a unit; one that cannot be read may have any, and `_number` refuses it."""
    try:
        return same_dimension(split_quantity(text)[1] or "1", unit)
    except UnitError:
        return True


def _number(name: str, text: str, unit: str) -> float:
    wanted = short_unit(f"({unit}){_SUFFIX[name]}")
    try:
        return convert(text, wanted)
    except UnitError as error:
        expected = f"a quantity such as 0.1 {wanted}"
        raise Problem(message=str(error), key=name, got=text, expected=expected, hint=error.hint).error from None
