"""Where blocks say that their outputs have a corner or a jump, there is one."""

import inspect
import itertools
import math
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.contract.drawn import random_block
from proofmass.runner.plan.constants import constants_of

PERIOD, OTHERS = 1e-3, (-0.37, 0.37)  # seconds of a tick, and what the inputs are that are held
SIZES = np.geomspace(1e-9, 1e6, 600).tolist()
PLACES = [-size for size in reversed(SIZES)] + SIZES
TIMES = [size for size in SIZES if size > 1e-4]
SOMETIMES = {"ArcTangent2", "InertialErrors", "IntegralNonlinearity", "Power"}
WITH_CORNERS = {
    (name, corner, argument): kind
    for name, kind in all_blocks().items()
    for corner, behaviour in kind.corners.items()
    for argument in behaviour.arguments
}


def called(block: Block, behaviour: Any, argument: str, others: float) -> Callable[[float], float]:
    """A function of a block by one of its arguments."""
    made = constants_of(block, block, PERIOD)
    known = {"time": 0.0, "normal": 0.0} | dict.fromkeys(type(block).inputs, others)

    def at(value: float) -> float:
        return float(behaviour.function(made, *({**known, argument: value}[name] for name in behaviour.arguments)))

    return at


def changes(side: Callable[[float], float], places: list[float]) -> Iterator[tuple[float, float]]:
    """Yield the neighbours between which a corner function goes to its other side, or counts on."""
    sides = list(map(side, places))
    for i in range(1, len(places)):
        below, above = places[i - 1], places[i]
        while sides[i] != sides[i - 1] and above - below > 1e-12 * max(-below, above, 1e-9):
            middle = 0.5 * (below + above)
            below, above = (middle, above) if side(middle) == sides[i - 1] else (below, middle)
        if sides[i] != sides[i - 1]:
            yield below, above


def bends(output: Callable[[float], float], below: float, above: float) -> bool:
    """Return whether a value, a slope or a curvature on one side is another one than on the other side."""
    step = 1e-3 * (abs(above) if abs(above) > 1e-15 else 1.0)
    left, right = ([output(start + k * way) for k in (1, 2, 3)] for start, way in ((below, -step), (above, step)))
    if not np.isfinite([*left, *right]).all():
        return True
    least = 1e-12 * max(map(abs, (*left, *right)))
    slopes = left[0] - left[1], right[1] - right[0]  # times the step
    curvatures = [one[0] - 2.0 * one[1] + one[2] for one in (left, right)]
    jumps = abs(right[0] - left[0]) > least + 5.0 * max(map(abs, slopes))
    turns = abs(slopes[1] - slopes[0]) > least + 5.0 * max(map(abs, curvatures))
    return jumps or turns or abs(curvatures[1] - curvatures[0]) > least + 0.1 * max(map(abs, curvatures))


def test_what_is_smooth_does_not_bend() -> None:
    for place in (-2.0, -0.7, 1e-9, 0.2, 1.3):
        for smooth in (math.sin, math.atan, lambda u: u * u, lambda u: 3.0 * u - 2.0, lambda u: 1.0 / (2000.0 + u)):
            assert not bends(smooth, place, math.nextafter(place, math.inf))
            assert bends(lambda u, of=smooth, p=place: of(u) + 0.2 * (u > p), place, math.nextafter(place, math.inf))


@pytest.mark.parametrize(("name", "corner", "argument"), WITH_CORNERS)
def test_outputs_have_a_corner_where_blocks_say_so(name: str, corner: str, argument: str, tmp_path: Path) -> None:
    """Everywhere, or with some parameters and other inputs alone."""
    kind, dice, found = WITH_CORNERS[name, corner, argument], random.Random(name), list[bool]()
    counts = inspect.get_annotations(kind.corners[corner].function, eval_str=True)["return"] is int
    places = TIMES if argument == "time" else PLACES
    for block, others in itertools.product([kind(), *(random_block(kind, dice, tmp_path) for _ in range(3))], OTHERS):
        outputs = [called(block, behaviour, argument, others) for behaviour in kind.output_functions.values()]
        beyond = called(block, kind.corners[corner], argument, others)
        sides = changes(beyond if counts else lambda place, of=beyond: math.copysign(1.0, of(place)), places)
        found += [any(bends(output, *ends) for output in outputs) for ends in itertools.islice(sides, 8)]
    assert any(found) if name in SOMETIMES else found and all(found)
