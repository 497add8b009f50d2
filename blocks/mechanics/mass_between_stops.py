"""Proof mass with mechanical stops: m x'' + c x' + k x = F between `lowest` and `highest`, rebound v -> -e v at both.

What rebounds at no more than `sticking_speed` stays at the stop until forces point away from it.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.mechanics.mass_spring_damper import displacement, velocity


class MassBetweenStops(Block):
    """Proof mass, suspension and damping, with stops that it hits by shock or pull-in."""

    mass: float = param("kg", "Proof mass.", default=50.43e-9, above=0.0)
    damping: float = param("kg/s", "Viscous damping.", default=3.4e-3, at_least=0.0)
    stiffness: float = param("N/m", "Stiffness of the suspension.", default=49.5627, at_least=0.0)
    lowest: float = param("m", "Displacement at the lower stop.", default=-1.9e-6)
    highest: float = param("m", "Displacement at the upper stop.", default=1.9e-6)
    restitution: float = param("1", "Speed after a rebound by speed before, e.", default=0.0, at_least=0.0, at_most=1.0)
    sticking_speed: float = param("m/s", "Speed of a rebound that does not leave the stop.", default=1e-9, at_least=0.0)
    initial_displacement: float = param("m", "Displacement at the start.", default=0.0)

    force = Input("N", "Force on the proof mass.")


class State(NamedTuple):
    displacement: float
    velocity: float
    held: int  # -1 or 1: at which stop
    hit_at: float


@MassBetweenStops.requires
def requires(p: MassBetweenStops) -> Iterator[tuple[str, str]]:
    if p.lowest >= p.highest:
        yield "lowest", f"less than highest = {p.highest:g} m"
    if not p.lowest <= p.initial_displacement <= p.highest:
        yield "initial_displacement", f"from {p.lowest:g} m to {p.highest:g} m"


@MassBetweenStops.start
def start(p: MassBetweenStops) -> State:
    return State(p.initial_displacement, 0.0, 0, 0.0)


MassBetweenStops.output("m")(displacement)
MassBetweenStops.output("m/s")(velocity)


@MassBetweenStops.output("1")
def contact(p: MassBetweenStops, x: State) -> int:
    """-1 while it is held at the lower stop, 1 at the upper, 0 elsewhere."""
    return x.held


@MassBetweenStops.output("s")
def last_impact(p: MassBetweenStops, x: State) -> float:
    """Time of the last impact on a stop."""
    return x.hit_at


@MassBetweenStops.derivative(linear=False)
def derivative(p: MassBetweenStops, x: State, force: float) -> State:
    free = 1.0 if x.held == 0 else 0.0
    return State(free * x.velocity, free * acceleration(p, x, force), 0, 0.0)


def acceleration(p: MassBetweenStops, x: State, force: float) -> float:
    return (force - p.damping * x.velocity - p.stiffness * x.displacement) / p.mass


def hit(p: MassBetweenStops, x: State, time: float) -> State:
    side, stop = (1, p.highest) if x.velocity > 0.0 else (-1, p.lowest)
    rebound = -p.restitution * x.velocity
    sticks = abs(rebound) <= p.sticking_speed
    return State(stop, 0.0 if sticks else rebound, side if sticks else 0, time)


def release(p: MassBetweenStops, x: State) -> State:
    return State(x.displacement, 0.0, 0, x.hit_at)


@MassBetweenStops.event(then=hit)
def clearance(p: MassBetweenStops, x: State) -> float:
    return p.highest - x.displacement if x.velocity > 0.0 else x.displacement - p.lowest if x.velocity < 0.0 else 1.0


@MassBetweenStops.event(then=release)
def pressure(p: MassBetweenStops, x: State, force: float) -> float:
    return 1.0 if x.held == 0 else x.held * acceleration(p, x, force)
