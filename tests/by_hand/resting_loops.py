"""Loops that do not rest at their start, as graphs, with their points of rest in closed form.

- quadratic loop: x' = x + g T (u - x - x^2 / 2), rests at sqrt(1 + 2 u) - 1 with the loop gain g T (1 + x) / (z - 1)
- hardening spring: m x'' + c x' + k x + a x^3 = F, rests at the only real root of k x + a x^3 = F where k > 0
- plate: k x = C d V^2 / (2 (d - x)^2), pulled in from V = sqrt(8 k d^2 / (27 C)) on (Sarraf et al. 2012, equation 8)
"""

import math

import mpmath

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph

QUADRATIC = """
name = "quadratic loop"
rate = "1 kHz"
samples = 400
wires = ["level.output -> error.first", "plant.output -> curve.temperature", "curve.value -> error.second",
         "error.output -> gain.input", "gain.output -> plant.input"]
probes = ["plant.output"]
[loops.main]
open_at = "plant.output"
[blocks.level]
kind = "Constant"
value = 2.0
[blocks.error]
kind = "Difference"
[blocks.gain]
kind = "Gain"
gain = 100.0
[blocks.plant]
kind = "DiscreteIntegrator"
output_unit = "1"
[blocks.curve]
kind = "PolynomialModel"
temperature_unit = "1"
unit = "1"
c1 = 1.0
c2 = 0.5
"""

SPRING = """
name = "hardening spring"
rate = "100 kHz"
duration = "20 ms"
wires = ["push.output -> total.first", "spring.force -> total.second", "total.output -> mass.force",
         "mass.displacement -> spring.displacement", "mass.displacement -> pickoff.input"]
probes = ["pickoff.output"]
[blocks.push]
kind = "Constant"
unit = "N"
value = 2e-5
[blocks.total]
kind = "Sum"
unit = "N"
[blocks.mass]
kind = "MassSpringDamper"
[blocks.spring]
kind = "DuffingSpring"
cubic = 3e14
[blocks.pickoff]
kind = "Gain"
input_unit = "m"
output_unit = "V"
gain = 1e6
"""
STIFFNESS = 49.5627  # N/m, that of a MassSpringDamper

PLATE = """
name = "plate"
rate = "100 kHz"
duration = "20 ms"
wires = ["drive.output -> plate.voltage", "plate.force -> mass.force", "mass.displacement -> plate.displacement"]
probes = ["mass.displacement"]
[blocks.drive]
kind = "Constant"
unit = "V"
[blocks.mass]
kind = "MassSpringDamper"
[blocks.plate]
kind = "GapClosingActuator"
push_pull = false
bias = 30.0
"""
# A follower of a turn, a quarter of a fringe behind: x += 0.3 cos(turn - x), so that it rests at turn + pi / 2.
FRINGES = """
name = "fringes"
rate = "1 kHz"
duration = "100 ms"
wires = [
    "turn.output -> apart.first", "follower.output -> apart.second", "apart.output -> light.phase",
    "light.power -> error.first", "mean.output -> error.second", "error.output -> follower.input",
]

[blocks.turn]
kind = "Constant"
value = "0 rad"
unit = "rad"

[blocks.apart]
kind = "Difference"
unit = "rad"

[blocks.light]
kind = "Interferometer"
peak = "2 W"

[blocks.mean]
kind = "Constant"
value = "1 W"
unit = "W"

[blocks.error]
kind = "Difference"
unit = "W"

[blocks.follower]
kind = "DiscreteIntegrator"
gain = "300 rad/(W s)"
input_unit = "W"
output_unit = "rad"
"""
GAP, CAPACITANCE = 4e-6, 0.1e-12
PULL_IN = math.sqrt(8.0 * STIFFNESS * GAP**2 / (27.0 * CAPACITANCE))


def quadratic_loop(more: str = "") -> Graph:
    """The quadratic loop, with more in its file."""
    return read_graph_text(QUADRATIC + more)


def quadratic_rest(level: float) -> float:
    return math.sqrt(1.0 + 2.0 * level) - 1.0


def spring_rest(force: float, cubic: float, stiffness: float) -> float:
    """Displacement in um, which is the voltage of the pickoff."""
    with mpmath.workdps(40):
        (root,) = (
            x
            for x in mpmath.polyroots([-force, stiffness * 1e-6, 0, cubic * 1e-18], 200, asc=True)
            if abs(x.imag) < 1e-25
        )
        return float(root.real)


def plate_rest(voltage: float, stiffness: float) -> float:
    """Displacement in m; the smallest root."""
    with mpmath.workdps(40):
        a = mpmath.mpf(CAPACITANCE) * voltage**2 / (2 * stiffness * mpmath.mpf(GAP) ** 2)  # y (1 - y)^2 = a
        roots = mpmath.polyroots([-a, 1, -2, 1], 200, asc=True)
        return float(min(x.real for x in roots if abs(x.imag) < 1e-25) * GAP)
