"""Pendulum drawn to its stop: plate_angle = stop_angle while `attach` is true, else the angle of the pendulum.

In open loop the plate of a quartz accelerometer lies on a fixed one; the bridge then reads eq. 16
whatever the acceleration (digital quartz accelerometer, section III.A, Fig. 4).
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class PlateAttach(Block):
    """Holds the plate on a fixed one on command; the pendulum behind it moves on by itself."""

    stop_angle: float = param("rad", "Angle of the plate on the stop, gap over lever.", default=1.25e-3)

    angle = Input("rad", "Angle of the pendulum.")
    attach = Input("1", "Whether the plate lies on the stop.", dtype=bool, default=False)


@PlateAttach.output("rad")
def plate_angle(p: PlateAttach, angle: float, attach: bool) -> float:
    """Angle of the plate."""
    return p.stop_angle if attach else angle
