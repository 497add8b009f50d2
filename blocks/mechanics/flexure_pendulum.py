"""Flexure pendulum of a quartz accelerometer, J th'' + C th' + D th = M (digital quartz accelerometer, eq. 1 to 3)."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class FlexurePendulum(Block):
    """Pendulous proof mass on a quartz flexure with gas damping."""

    inertia: float = param("kg*m^2", "Moment of inertia about the flexure.", default=1.0e-7, above=0.0)
    damping: float = param("N*m*s/rad", "Viscous damping.", default=4.0e-4, at_least=0.0)
    stiffness: float = param("N*m/rad", "Stiffness of the flexure.", default=3.0e-3, above=0.0)

    torque = Input("N*m", "Torque about the flexure.")


class State(NamedTuple):
    angle: float
    angular_velocity: float


@FlexurePendulum.output("rad")
def angle(p: FlexurePendulum, x: State) -> float:
    """Angle of the pendulum from rest."""
    return x.angle


@FlexurePendulum.output("rad/s")
def angular_velocity(p: FlexurePendulum, x: State) -> float:
    """Angular velocity of the pendulum."""
    return x.angular_velocity


@FlexurePendulum.derivative(linear=True)
def derivative(p: FlexurePendulum, x: State, torque: float) -> State:
    return State(x.angular_velocity, (torque - p.damping * x.angular_velocity - p.stiffness * x.angle) / p.inertia)
