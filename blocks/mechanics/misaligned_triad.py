"""Triad with small errors: x = (1 + sx) X + mxy Y + mxz Z, and so on for y and z.

X, Y, Z are true components, x, y, z what the axes sense; mxy is the angle by which axis x leans to
Y (IEEE Std 1293).
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class MisalignedTriad(Block):
    """Scale and direction errors of three axes: how sensors sit on their block."""

    scale_x: float = param("1", "Relative scale error sx.", default=0.0)
    scale_y: float = param("1", "Relative scale error sy.", default=0.0)
    scale_z: float = param("1", "Relative scale error sz.", default=0.0)
    xy: float = param("rad", "Angle of axis x to Y, mxy.", default=0.0)
    xz: float = param("rad", "Angle of axis x to Z, mxz.", default=0.0)
    yx: float = param("rad", "Angle of axis y to X, myx.", default=0.0)
    yz: float = param("rad", "Angle of axis y to Z, myz.", default=0.0)
    zx: float = param("rad", "Angle of axis z to X, mzx.", default=0.0)
    zy: float = param("rad", "Angle of axis z to Y, mzy.", default=0.0)
    unit: str = param("", "Unit of inputs and outputs.", default="m/s^2")

    true_x = Input("{unit}", "True component along X.")
    true_y = Input("{unit}", "True component along Y.")
    true_z = Input("{unit}", "True component along Z.")


@MisalignedTriad.output("{unit}")
def sensed_x(p: MisalignedTriad, true_x: float, true_y: float, true_z: float) -> float:
    """Component along the sensing axis x."""
    return (1.0 + p.scale_x) * true_x + p.xy * true_y + p.xz * true_z


@MisalignedTriad.output("{unit}")
def sensed_y(p: MisalignedTriad, true_x: float, true_y: float, true_z: float) -> float:
    """Component along the sensing axis y."""
    return p.yx * true_x + (1.0 + p.scale_y) * true_y + p.yz * true_z


@MisalignedTriad.output("{unit}")
def sensed_z(p: MisalignedTriad, true_x: float, true_y: float, true_z: float) -> float:
    """Component along the sensing axis z."""
    return p.zx * true_x + p.zy * true_y + (1.0 + p.scale_z) * true_z
