"""Temperature profile: T = T_i + s min(pace max(t - t_i - soak_time, 0), |T_(i+1) - T_i|) for t_i <= t < t_(i+1).

Each temperature T_i is reached at t_i and held for soak_time; s is the sign of T_(i+1) - T_i. The
last one stays.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Buffer, param
from proofmass.blocks.sources.piecewise_constant import index_at


class TemperatureProfile(Block):
    """A climatic chamber that soaks at one temperature after the other, with ramps between."""

    temperatures: tuple[float, ...] = param(
        "K", "The temperatures, in their order.", default=(298.15, 233.15, 358.15, 298.15), above=0.0
    )
    soak_time: float = param("s", "Time that each is held.", default=3600.0, at_least=0.0)
    pace: float = param("K/s", "Pace of the temperature between them.", default=1.0 / 60.0, above=0.0)

    levels = Buffer("The temperatures.", float, ("temperatures",))
    begins = Buffer("Times at which each is reached, in seconds.", float, ("temperatures",))


class State(NamedTuple):
    entry: int


@TemperatureProfile.start
def start(p: TemperatureProfile, levels: list[float], begins: list[float]) -> State:
    levels[0], begins[0] = p.temperatures[0], 0.0
    for i in range(1, len(p.temperatures)):
        levels[i] = p.temperatures[i]
        begins[i] = begins[i - 1] + p.soak_time + abs(levels[i] - levels[i - 1]) / p.pace
    return State(0)


@TemperatureProfile.output("K")
def temperature(p: TemperatureProfile, x: State, levels: list[float], begins: list[float], time: float) -> float:
    """The temperature."""
    i = index_at(time, x.entry, begins)
    if i + 1 == len(levels):
        return levels[i]
    way = levels[i + 1] - levels[i]
    gone = p.pace * (time - begins[i] - p.soak_time)
    return levels[i] + (clip(gone, 0.0, way) if way > 0.0 else -clip(gone, 0.0, -way))


@TemperatureProfile.update
def update(p: TemperatureProfile, x: State, begins: list[float], time: float) -> State:
    return State(index_at(time, x.entry, begins))
