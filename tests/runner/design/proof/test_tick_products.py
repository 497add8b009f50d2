"""Loops multiplied tick by tick, at random places of a box, against matrices of SciPy that are written down by hand."""

import itertools
import random
from typing import Any

import flint
import numpy as np
import pytest
import scipy.linalg

from proofmass import Graph, blocks
from proofmass.runner.derivatives.ball import BITS
from proofmass.runner.design.proof.ball_map import StartingLoop
from proofmass.runner.design.proof.box_maps import BoxMaps
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.closed_loop import closed_loops
from proofmass.runner.design.proof.look import BoxLook
from proofmass.runner.design.proof.wire_factors import GAIN, PHASE, Factor
from proofmass.runner.planning.plan import plan

SLOW = 4  # ticks of the integrator
NAMES = ("plant.stiffness", "read.gain", "slow.gain")
BOX = ((38_500.0, 40_000.0), (-2_500.0, -1_500.0), (-2e5, -1e5))  # N/m, N/m and N/(m s)
GRAPH = Graph(
    name="a light mode, held at once and slowly",
    rate="1 kHz",
    samples=10,
    blocks={
        "plant": blocks.MassSpringDamper(mass=1.0, damping=8.0, stiffness=39_000.0),
        "read": blocks.Gain(gain=-2_000.0, input_unit="m", output_unit="N"),
        "slow": blocks.DiscreteIntegrator(gain=-1.5e5, input_unit="m", output_unit="N"),
        "held": blocks.Sum(unit="N"),
    },
    wires=[
        "plant.displacement -> read.input",
        "plant.displacement -> slow.input",
        "read.output -> held.first",
        "slow.output -> held.second",
        "held.output -> plant.force",
    ],
    rates={"read": 1_000, "held": 1_000, "slow": 250},
    probes=["held.output"],
)


def by_hand(stiffness: float, gain: float, slow: float, factor: complex) -> Any:
    """Displacement, velocity and the integral after four ticks: its output is held in all of them."""
    whole = scipy.linalg.expm(np.array([[0.0, 1.0, 0.0], [-stiffness, -8.0, 1.0], [0.0, 0.0, 0.0]]) * 1e-3)
    tick = np.eye(4, dtype=complex)  # displacement, velocity, what is held, and the integral
    tick[:2, :2], tick[:2, 2] = whole[:2, :2], whole[:2, 2] * factor
    tick[:2, 0] += whole[:2, 2] * factor * gain
    begin = np.eye(4, dtype=complex)
    begin[2] = [0.0, 0.0, 0.0, 1.0]
    begin[3, 0] = 4e-3 * slow
    return (np.linalg.matrix_power(tick, SLOW) @ begin)[np.ix_([0, 1, 3], [0, 1, 3])]


def maps() -> BoxMaps:
    loop = StartingLoop(plan(GRAPH), ("held", "output"))
    assert loop.in_ticks
    return BoxMaps(loop, lambda values: dict(zip(NAMES, values, strict=True)))


MAPS = maps()


def invariants(matrix: Any) -> Any:
    """The characteristic polynomial, whatever coordinates the states have."""
    return np.poly(matrix)


@pytest.mark.parametrize(("factor", "ends"), [(GAIN, (0.5, 2.0)), (PHASE, (0.0, 0.5)), (GAIN, (1.0, 1.0))])
@pytest.mark.parametrize("framed", [False, True])
def test_what_lies_beyond_the_corners_is_bounded(factor: Factor, ends: tuple[float, float], framed: bool) -> None:
    draw = random.Random(7)
    frame = np.array([[1.0, 0.5, 0.0], [20.0, 200.0, 3.0], [100.0, 0.0, 4_000.0]])
    with flint.ctx.workprec(BITS):
        opened = MAPS.open(BOX)
        family = closed_loops(factor, opened.framed(frame) if framed else opened, ends)
        bends = [term for terms in family.bends.values() for term in terms]
        unknown = sum(family.shares.values(), 0.0 * family.centre) + 1e-9 * np.abs(family.corners.middle).max(axis=0)
        sides = (*BOX, ends)
        for _ in range(4):
            parts = [draw.random() for _ in sides]
            place = [low + part * (high - low) for part, (low, high) in zip(parts, sides, strict=True)]
            point = tuple((value, value) for value in place[:3])
            there = MAPS.open(point)
            there = there.framed(frame) if framed else there
            exact = closed_loops(factor, there, (place[3], place[3])).corners.middle[0]
            corners = itertools.product(*((1.0 - part, part) for part in parts[: 3 + (ends[0] < ends[1])]))
            weights = np.array([np.prod(of) for of in corners])
            mixed = np.tensordot(weights, family.corners.middle, 1)
            assert (np.abs(exact - mixed) <= unknown + sum(map(np.abs, bends))).all()
            size = np.linalg.norm(unknown) + sum(np.linalg.norm(term, 2) for term in bends)
            assert np.linalg.norm(exact - mixed, 2) <= size
            value = place[3] if factor is GAIN else np.exp(1j * place[3])
            own = by_hand(*place[:3], value)
            whole = own.real if factor is GAIN else np.block([[own.real, -own.imag], [own.imag, own.real]])
            assert invariants(exact) == pytest.approx(invariants(whole), rel=1e-6, abs=1e-9)


def test_ticks_that_are_alike_are_one() -> None:
    with flint.ctx.workprec(BITS):
        opened = MAPS.open(BOX)
    assert opened.ticks is not None
    first, *others = opened.ticks.of.order
    assert len(set(others)) == 1
    assert first not in others


@pytest.mark.parametrize("moves", [False, True])
def test_a_region_is_proved_in_coordinates_of_its_own(moves: bool) -> None:
    """Under any change all regions share one norm, so that their coordinates are those of the states."""
    claim = Claim("main", "held.output", "stable", 0.0, period=4e-3, any_change=moves)
    part = 0.02 if moves else 0.25
    whole = (*((low, low + part * (high - low)) for low, high in BOX), (1.0, 1.0))
    region = BoxLook(MAPS, claim, whole, lambda box: False).at(whole, None).region
    assert region is not None
    assert (region.loops.frame is None) is moves
    assert np.array_equal(region.transform, np.eye(3)) is not moves
