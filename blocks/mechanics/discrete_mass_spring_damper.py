"""Mass, spring and damper stepped as digital hardware would: m x'' + c x' + k x = F by two integrators of step T.

v1 = v + T a, x1 = x + T v, where a = (F - c v - k x) / m is taken partly before the step, partly at
its end, and so is v. Forward Euler: both before (0, 0); semi-implicit: the new v (0, 1); Tustin's
rule: means of both (1/2, 1/2), F held. Sarraf et al. 2012 (section 2.1, Fig. 2e) build their
reference model of two integrators and do not say which. Forward Euler takes T k off the damping and
is stable only for T < c / k. A MassSpringDamper is exact.
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.mechanics.mass_spring_damper import State, displacement, velocity


class DiscreteMassSpringDamper(Block):
    """Reference model of a resonator, of two digital integrators."""

    mass: float = param("kg", "Proof mass.", default=50.43e-9, above=0.0)
    damping: float = param("kg/s", "Viscous damping.", default=3.4e-3, at_least=0.0)
    stiffness: float = param("N/m", "Stiffness of the suspension.", default=49.5627, above=0.0)
    acceleration_at_end: float = param(
        "1", "Part of the acceleration that is taken at the end of a step.", default=0.0, at_least=0.0, at_most=1.0
    )
    velocity_at_end: float = param(
        "1", "Part of the velocity that is taken at the end of a step.", default=1.0, at_least=0.0, at_most=1.0
    )

    force = Input("N", "Force on the proof mass.")


class Constants(NamedTuple):
    by_displacement: float  # of the velocity at the end of a step
    by_velocity: float
    by_force: float
    before: float  # T times the part of either velocity that moves the displacement
    after: float


@DiscreteMassSpringDamper.constants
def constants(p: DiscreteMassSpringDamper, period: float) -> Constants:
    damper, spring = period * p.damping / p.mass, period * p.stiffness / p.mass
    before, after = period * (1.0 - p.velocity_at_end), period * p.velocity_at_end
    scale = 1.0 / (1.0 + p.acceleration_at_end * (damper + after * spring))
    kept = 1.0 - (1.0 - p.acceleration_at_end) * damper - p.acceleration_at_end * before * spring
    return Constants(-spring * scale, kept * scale, period / p.mass * scale, before, after)


DiscreteMassSpringDamper.output("m")(displacement)
DiscreteMassSpringDamper.output("m/s")(velocity)


@DiscreteMassSpringDamper.update
def update(c: Constants, x: State, force: float) -> State:
    velocity = c.by_displacement * x.displacement + c.by_velocity * x.velocity + c.by_force * force
    return State(x.displacement + c.before * x.velocity + c.after * velocity, velocity)
