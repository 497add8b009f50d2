"""Bridge and pulses over a period in closed form, and with a coil."""

import numpy as np
import pytest

from proofmass.blocks import Constant, HBridge, LowPass, PulseWidthModulator
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive

TICK, TICKS = 1e-6, 50  # 20 kHz


def over_a_period(bridge: HBridge, high: int, current: float) -> float:
    """Mean voltage over the second period, which is on for some ticks."""
    rows = [{"on": n % TICKS < high, "current": current} for n in range(2 * TICKS)]
    return float(np.mean([row["voltage"] for row in drive(bridge, rows, period=TICK)[TICKS:]]))


@pytest.mark.parametrize("dead", [0.0, 0.35e-6, 1e-6, 2.6e-6])
@pytest.mark.parametrize("current", [1.5, -0.8])
@pytest.mark.parametrize("high", [10, 30])
def test_over_a_period(high: int, current: float, dead: float) -> None:
    """2 D - 1 of the supply. In two dead times diodes take the current, and the switches carry it in what is left."""
    bridge = HBridge(supply=12.0, on_resistance=0.2, dead_time=dead, forward_voltage=0.8)
    duty, part = high / TICKS, dead / (TICKS * TICK)
    high_side, low_side = duty - part, 1.0 - duty - part
    switched = 12.0 * (high_side - low_side) - 2.0 * 0.2 * current * (high_side + low_side)
    diodes = -2.0 * part * (12.0 + 2.0 * 0.8) * np.sign(current)
    assert over_a_period(bridge, high, current) == pytest.approx(switched + diodes, abs=1e-12)


def test_without_a_current_the_open_bridge_floats() -> None:
    bridge = HBridge(supply=10.0, dead_time=2e-6)
    rows = [{"on": n >= 2, "current": 0.0} for n in range(6)]
    assert [row["voltage"] for row in drive(bridge, rows, period=TICK)] == [-10.0, -10.0, 0.0, 0.0, 10.0, 10.0]


def test_a_pulse_shorter_than_the_dead_time_closes_no_switch() -> None:
    rows = [{"on": n == 3, "current": 1.0} for n in range(8)]
    answer = [
        row["voltage"] for row in drive(HBridge(supply=9.0, on_resistance=0.0, dead_time=2e-6), rows, period=TICK)
    ]
    assert answer == [-9.0] * 3 + [pytest.approx(-10.4)] * 3 + [-9.0] * 2


def coil(duty: float, dead: float) -> float:
    """Mean current of 4 ohm and 2 mH behind the bridge, once it has settled."""
    graph = Graph(
        name="a coil",
        rate=1.0 / TICK,
        blocks={
            "duty": Constant(value=2.0 * duty - 1.0),
            "pulses": PulseWidthModulator(frequency=20e3),
            "bridge": HBridge(supply=12.0, on_resistance=0.2, dead_time=dead, forward_voltage=0.8),
            "coil": LowPass(gain=0.25, corner_frequency=4.0 / (2.0 * np.pi * 2e-3), input_unit="V", output_unit="A"),
        },
        wires=[
            "duty.output -> pulses.input",
            "pulses.on -> bridge.on",
            "coil.output -> bridge.current",
            "bridge.voltage -> coil.input",
        ],
        probes=["coil.output"],
    )
    return float(np.mean(simulate(graph, samples=10_000, engine="compiled")["coil.output"].values[-20 * TICKS :]))


def test_the_current_of_a_coil() -> None:
    """The mean voltage over both resistances: no dead time, then one that takes 2 (supply + 2 Vf) dead / period."""
    assert coil(0.8, 0.0) == pytest.approx(12.0 * 0.6 / 4.4, rel=1e-3)
    part = 0.5e-6 / (TICKS * TICK)
    expected = (12.0 * 0.6 - 2.0 * part * (12.0 + 1.6)) / (4.0 + 0.4 * (1.0 - 2.0 * part))
    assert coil(0.8, 0.5e-6) == pytest.approx(expected, rel=1e-3)
