"""Where blocks say that they bend or jump, against the places of their equations.

Solvers end their steps there. Here the functions run as they are written.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from proofmass.blocks import (
    Absolute,
    ArcSine,
    ArcTangent2,
    Chirp,
    DeadZone,
    DifferentialComb,
    DriftRamp,
    FibreCoupler,
    GapCapacitorPair,
    InertialErrors,
    IntegralNonlinearity,
    Logarithm,
    Maximum,
    Minimum,
    Power,
    Pulse,
    Quotient,
    Ramp,
    Saturation,
    Sign,
    SquareRoot,
    Step,
    TemperatureCycle,
)
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.plan.constants import constants_of

WIDE = 4.0  # of an input that is scanned
CELL = 0.0101  # width of a step of the scan; no place below is an edge of a cell

# a block, the input that moves, the others, the places where it bends or jumps, and their unit
BENT: list[tuple[Block, str, dict[str, float], Sequence[float], float]] = [
    (Absolute(), "input", {}, (0.0,), 1.0),
    (ArcSine(reference=2.0), "input", {}, (-2.0, 2.0), 1.0),
    (ArcTangent2(), "quadrature", {"in_phase": -1.0}, (0.0,), 1.0),
    (DeadZone(lowest=-0.5, highest=1.5), "input", {}, (-0.5, 1.5), 1.0),
    (
        DifferentialComb(overlap=20e-6),
        "displacement",
        {"first_voltage": 3.0, "second_voltage": 1.0},
        (-20.0, 20.0),
        1e-6,
    ),
    (GapCapacitorPair(gap=20e-6, lever=2.0), "displacement", {}, (-10.0, 10.0), 1e-6),
    (FibreCoupler(coupling=0.3), "first", {"second": 1.0, "phase": 0.7}, (0.0,), 1.0),
    (FibreCoupler(coupling=0.3), "second", {"first": 1.0, "phase": 0.7}, (0.0,), 1.0),
    (InertialErrors(asymmetry=0.1), "input", {"noise": 0.0, "acceleration": 0.0, "temperature": 300.0}, (0.0,), 1.0),
    (IntegralNonlinearity(bits=3, reference=2.5), "voltage", {}, (-2.5, 2.5), 1.0),
    (Logarithm(smallest=0.25), "input", {}, (0.25,), 1.0),
    (Maximum(), "first", {"second": 0.7}, (0.7,), 1.0),
    (Maximum(), "second", {"first": -0.7}, (-0.7,), 1.0),
    (Minimum(), "first", {"second": 0.7}, (0.7,), 1.0),
    (Power(exponent=1.0), "input", {}, (0.0,), 1.0),
    (Quotient(smallest=0.25), "denominator", {"numerator": 1.0}, (-0.25, 0.0, 0.25), 1.0),
    (Saturation(lowest=-0.5, highest=1.5), "input", {}, (-0.5, 1.5), 1.0),
    (Sign(), "input", {}, (0.0,), 1.0),
    (SquareRoot(), "input", {}, (0.0,), 1.0),
]
# a source, and the times at which it bends or jumps, up to WIDE seconds
TIMED: list[tuple[Block, Sequence[float]]] = [
    (Chirp(sweep_time=1.25, start_frequency=0.1, stop_frequency=0.3), (1.25,)),
    (DriftRamp(slope=2.0, start_time=1.5), (1.5,)),
    (Pulse(delay=0.5, repetition=1.0, duty=0.25), (0.5, 0.75, 1.5, 1.75, 2.5, 2.75, 3.5, 3.75)),
    (Ramp(slope=2.0, start_time=1.5), (1.5,)),
    (Step(start_time=0.5, duration=2.0), (0.5, 2.5)),
    (Step(start_time=0.5), (0.5,)),
    (TemperatureCycle(low=300.0, high=301.0, pace=2.0, soak_time=0.75), (0.5, 1.25, 1.75, 2.5, 3.0, 3.75)),
]


def value(block: Block, behaviour: Behaviour, given: Mapping[str, float]) -> float:
    """What a function of a block returns."""
    constants = constants_of(block, block, 1e-3)
    return float(behaviour.function(constants, *(given[name] for name in behaviour.arguments)))


def crossed(values: np.ndarray) -> set[int]:
    """The cells in which some value has another sign at the end than at the beginning, or another count."""
    return set(np.flatnonzero(values[1:] != values[:-1]).tolist())


@pytest.mark.parametrize(("block", "name", "others", "places", "scale"), BENT, ids=lambda one: type(one).__name__)
def test_inputs(block: Block, name: str, others: dict[str, float], places: Sequence[float], scale: float) -> None:
    edges = np.arange(-WIDE - 0.5 * CELL, WIDE, CELL) if scale == 1.0 else np.arange(-40.0 - 0.5 * CELL, 40.0, CELL)
    cells = {int(np.searchsorted(edges, place)) - 1 for place in places}
    told = set[int]()
    for corner in type(block).corners.values():
        if name in corner.arguments:
            told |= crossed(np.array([value(block, corner, {**others, name: e * scale}) > 0.0 for e in edges.tolist()]))
    assert told == cells


def test_each_block_with_corners_is_here() -> None:
    tested = {type(block) for block, *_ in (*BENT, *TIMED)}
    assert {kind for kind in all_blocks().values() if kind.corners} == tested


@pytest.mark.parametrize(("block", "places"), TIMED, ids=lambda one: type(one).__name__)
def test_times(block: Block, places: Sequence[float]) -> None:
    edges = np.arange(0.5 * CELL, WIDE, CELL)
    cells = {int(np.searchsorted(edges, place)) - 1 for place in places}
    (corner,) = type(block).corners.values()
    told = np.array([value(block, corner, {"time": time}) for time in edges.tolist()])
    if corner.returns is not int:
        told = told > 0.0
    assert crossed(told) == cells
    assert all(math.isfinite(one) for one in told)
