"""Proof mass on a flexure, m x'' + c x' + k x = F (Sarraf et al. 2012, section 2.1)."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class MassSpringDamper(Block):
    """Proof mass, suspension and gas damping of a mechanical accelerometer."""

    mass: float = param("kg", "Proof mass.", default=50.43e-9, above=0.0)
    damping: float = param("kg/s", "Viscous damping.", default=3.4e-3, at_least=0.0)
    stiffness: float = param("N/m", "Stiffness of the suspension.", default=49.5627, above=0.0)

    force = Input("N", "Force on the proof mass.")


class State(NamedTuple):
    displacement: float
    velocity: float


@MassSpringDamper.output("m")
def displacement(p: MassSpringDamper, x: State) -> float:
    """Displacement of the proof mass from rest."""
    return x.displacement


@MassSpringDamper.output("m/s")
def velocity(p: MassSpringDamper, x: State) -> float:
    """Velocity of the proof mass."""
    return x.velocity


@MassSpringDamper.derivative(linear=True)
def derivative(p: MassSpringDamper, x: State, force: float) -> State:
    return State(x.velocity, (force - (p.damping * x.velocity + p.stiffness * x.displacement)) / p.mass)
