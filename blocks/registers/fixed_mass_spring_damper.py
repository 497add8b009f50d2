"""Mass, spring and damper in registers: v += T (a - (c/m) v - (k/m) x), x += T v, in micrometres and milliseconds.

The reference model DUT-R of Sarraf et al. 2012 (section 2.1, Fig. 2e; section 3.1), of two digital
integrators. Large numbers have 6 bits after the point (accelerations, k/m, c/m), small ones 30
(velocity, displacement): one g moves their accelerometer by 0.00998 um. The sum of accelerations is
rounded once, each integrator once. Semi-implicit: x takes the new v; forward Euler: the one before.
The semi-implicit x is half a step ahead of v; leapfrog gives x - T v / 2 as the displacement, which
is of second order but for the force of the damper: a rule for resonators of little damping. k/m and
c/m are inputs, for controllers to move.
"""

from typing import Literal, NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedMassSpringDamper(Block):
    """Reference model of a resonator in fixed point, one step a tick."""

    method: Literal["forward_euler", "semi_implicit", "leapfrog"] = param(
        "", "Which velocity moves the displacement, and when it is given.", default="semi_implicit"
    )
    large_format: Fixed = param("1", "Format of acceleration and k/m.", default=Fixed(24, 6))
    damping_format: Fixed = param("1", "Format of c/m.", default=Fixed(24, 6))
    small_format: Fixed = param("1", "Format of velocity and displacement.", default=Fixed(32, 30))
    step_format: Fixed = param("1", "Format of the step T in milliseconds.", default=Fixed(32, 30))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of a register.", default="saturate")

    acceleration = Input("um/ms^2", "Force over mass.", dtype=FixedValue)
    stiffness = Input("1/ms^2", "Stiffness over mass, k/m.", dtype=FixedValue)
    damping = Input("1/ms", "Damping over mass, c/m.", dtype=FixedValue)


class State(NamedTuple):
    displacement: FixedValue
    velocity: FixedValue


class Constants(NamedTuple):
    step: FixedValue
    half: FixedValue


@FixedMassSpringDamper.formats
def formats(p: FixedMassSpringDamper) -> dict[str, Fixed]:
    large = dict.fromkeys(("acceleration", "stiffness"), p.large_format)
    small = dict.fromkeys(("x", "displacement", "velocity"), p.small_format)
    return {**large, **small, "damping": p.damping_format, "c": p.step_format}


@FixedMassSpringDamper.constants
def constants(p: FixedMassSpringDamper, period: float) -> Constants:
    step, half = (fixed(milliseconds, p.step_format, "half_even") for milliseconds in (1e3 * period, 500.0 * period))
    return Constants(step, half)


@FixedMassSpringDamper.output("um")
def displacement(c: Constants, p: FixedMassSpringDamper, x: State) -> FixedValue:
    """Displacement of the proof mass from rest."""
    if p.method == "leapfrog":
        return (x.displacement - c.half * x.velocity).to(p.small_format, p.rounding, p.overflow)
    return x.displacement


@FixedMassSpringDamper.output("um/ms")
def velocity(p: FixedMassSpringDamper, x: State) -> FixedValue:
    """Velocity of the proof mass."""
    return x.velocity


@FixedMassSpringDamper.update
def update(
    c: Constants,
    p: FixedMassSpringDamper,
    x: State,
    acceleration: FixedValue,
    stiffness: FixedValue,
    damping: FixedValue,
) -> State:
    rest = acceleration - damping * x.velocity - stiffness * x.displacement
    change = c.step * rest.to(p.large_format, p.rounding, p.overflow)
    after = (x.velocity + change).to(p.small_format, p.rounding, p.overflow)
    moving = x.velocity if p.method == "forward_euler" else after
    return State((x.displacement + c.step * moving).to(p.small_format, p.rounding, p.overflow), after)
