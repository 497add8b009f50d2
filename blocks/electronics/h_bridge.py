"""H-bridge: voltage = s supply - 2 Ron i, s = 1 while `on`, else -1; -sign(i) (supply + 2 Vf) in the dead time.

All switches are open for a dead time after each change, and the current of an inductive load goes
through two diodes into the supply. The output is the mean over the tick, so that a dead time need
not be whole ticks (Mohan, Undeland and Robbins, Power Electronics, 2003, section 8-5: of each
period it takes 2 supply times its part).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class HBridge(Block):
    """Full bridge of switches for a load: behind a PulseWidthModulator the power stage of a motor, a coil, a heater."""

    supply: float = param("V", "Supply voltage.", default=5.0, at_least=0.0)
    on_resistance: float = param("ohm", "Resistance Ron of each closed switch; two carry i.", default=0.1, at_least=0.0)
    dead_time: float = param("s", "Time in which all switches are open after a change.", default=0.0, at_least=0.0)
    forward_voltage: float = param("V", "Forward voltage Vf of a diode.", default=0.7, at_least=0.0)

    on = Input("1", "Which way the load is at the supply; off before tick 0.", dtype=bool)
    current = Input("A", "Current i of the load, out of the bridge.", default=0.0)


class State(NamedTuple):
    was_on: bool
    left: float  # of the dead time, in ticks


class Constants(NamedTuple):
    supply: float
    resistance: float  # of two switches
    dead: float  # in ticks
    diodes: float  # V


@HBridge.constants
def constants(p: HBridge, period: float) -> Constants:
    return Constants(p.supply, 2.0 * p.on_resistance, p.dead_time / period, p.supply + 2.0 * p.forward_voltage)


def dead(c: Constants, x: State, on: bool) -> float:
    """Return what is left of the dead time at the start of a tick, in ticks."""
    return c.dead if on != x.was_on else x.left


@HBridge.output("V")
def voltage(c: Constants, x: State, on: bool, current: float) -> float:
    """Voltage across the load, in the mean over the tick."""
    part = min(dead(c, x, on), 1.0)
    through = -c.diodes if current > 0.0 else c.diodes if current < 0.0 else 0.0
    closed = (c.supply if on else -c.supply) - c.resistance * current
    return part * through + (1.0 - part) * closed


@HBridge.update
def update(c: Constants, x: State, on: bool) -> State:
    return State(on, max(dead(c, x, on) - 1.0, 0.0))
