"""The loop of `closed_loop_accelerometer.toml` in closed form, written out without the package."""

import math
from typing import Any

import numpy as np

PERIOD = 1.0 / 50e3


def open_loop(w: Any, inertia: float, damping: float, stiffness: float, gain: float) -> Any:
    """L(exp(j w T)): the pendulum held over a period in closed form, times the controller and a gain."""
    z = np.exp(1j * w * PERIOD)
    root = math.sqrt(damping**2 - 4.0 * inertia * stiffness)
    poles = ((-damping + root) / (2.0 * inertia), (-damping - root) / (2.0 * inertia))
    # 1 / (J (s - a) (s - b)) = [1/(s - a) - 1/(s - b)] / (J (a - b)), each held: (e^{aT} - 1) / (a (z - e^{aT})).
    parts = [(math.exp(a * PERIOD) - 1.0) / (a * (z - math.exp(a * PERIOD))) for a in poles]
    plant = (parts[0] - parts[1]) / (inertia * (poles[0] - poles[1]))
    decay = math.exp(-2.0 * math.pi * 2000.0 * PERIOD)
    pid = 0.06 + 6.0 * PERIOD * z / (z - 1.0) + 2.0e-5 / PERIOD * (1.0 - decay) * (z - 1.0) / (z - decay)
    return gain * plant * pid
