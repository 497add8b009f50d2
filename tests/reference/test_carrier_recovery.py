"""The loops of the library that follow a carrier, against linear theory: lock, phase noise, data.

Gardner, Phaselock Techniques, 2005: a step of the frequency moves the phase error of a loop of natural frequency wn and
damping 1/sqrt(2) by dw / wd e^(-z wn t) sin(wd t), wd = wn sqrt(1 - z^2); noise of one-sided density S gives it the
variance S B / P, P the power of the carrier and B = wn (z + 1 / (4 z)) / 2 in Hz.
"""

import math
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import NumericallyControlledOscillator, Step, Sum, WhiteNoise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate

RATE, CARRIER, AMPLITUDE, NATURAL = 400_000, 50_000.0, 2.0, 300.0
DAMPING, START = math.sqrt(0.5), 0.02  # the step comes when the loop has locked


def phase_error(part: str, offset: float, density: float, samples: int, folded: float) -> np.ndarray:
    """Phase of the carrier less that of the loop, in rad, within half of `folded` turns of zero."""
    loop = read_graph(library_file(f"{part}.toml"))
    changes: dict[str, Any] = {"natural_frequency": NATURAL, "nominal_frequency": CARRIER}
    changes |= {"amplitude": AMPLITUDE} if part == "phase_locked_loop" else {}
    graph = Graph(
        name="loop",
        rate=RATE,
        blocks={
            "step": Step(amplitude=offset, start_time=START, unit="Hz"),
            "carrier": NumericallyControlledOscillator(frequency=CARRIER, amplitude=AMPLITUDE, unit="V"),
            "noise": WhiteNoise(density=density, unit="V"),
            "received": Sum(unit="V"),
            "loop": loop.with_parameters(changes),
        },
        wires=[
            "step.output -> carrier.control",
            "carrier.sine -> received.first",
            "noise.output -> received.second",
            "received.output -> loop.signal",
        ],
        probes=["carrier.phase", "loop.phase"],
        seed=4,
    )
    result = simulate(graph, samples=samples, engine="compiled")
    error = result["carrier.phase"].values - result["loop.phase"].values
    return error - folded * np.round(error / folded)


@pytest.mark.parametrize(("part", "folded"), [("phase_locked_loop", 2.0 * math.pi), ("costas_loop", math.pi)])
def test_lock_time_and_phase_noise(part: str, folded: float) -> None:
    step, wn = 30.0, 2.0 * math.pi * NATURAL
    quiet = phase_error(part, step, 0.0, RATE // 25, folded)
    period = RATE // 50_000  # a mean over the carrier's period takes the ripple of the detector off
    smooth = np.convolve(quiet, np.ones(period) / period, mode="valid")
    t = (np.arange(len(smooth)) + 0.5 * (period - 1)) / RATE - START
    smooth, t = smooth[t > 0.0], t[t > 0.0]
    wd = wn * math.sqrt(1.0 - DAMPING**2)
    expected = 2.0 * math.pi * step / wd * np.exp(-DAMPING * wn * t) * np.sin(wd * t)
    assert np.abs(smooth - expected).max() < 0.1 * expected.max()
    locked = [t[np.abs(error) > 0.05 * expected.max()][-1] for error in (smooth, expected)]
    assert locked[0] == pytest.approx(locked[1], rel=0.1)

    density = 2e-3
    error = phase_error(part, 0.0, density, 2 * RATE, folded)[RATE // 50 :]
    bandwidth = 0.5 * wn * (DAMPING + 0.25 / DAMPING)
    variance = density**2 * bandwidth / (0.5 * AMPLITUDE**2)
    assert np.var(error) == pytest.approx(variance, rel=0.1)


def test_the_graph_finds_frequency_and_data() -> None:
    """40 Hz in both loops; in the middle of each bit the arm has its sign, or that of all bits is turned."""
    graph = read_graph(library_file("carrier_recovery.toml"))
    result = simulate(graph, engine="compiled")
    assert result.measures["plain"].value == pytest.approx(40.0, abs=0.5)
    assert result.measures["keyed"].value == pytest.approx(40.0, abs=0.5)
    middle = slice(50 * 100 + 60, None, 100)  # 100 ticks a bit; the arms lag by less than a tenth of one
    data, bits = result["keyed.data"].values[middle], result["signs.output"].values[middle]
    assert len(data) == 149 or len(data) == 150
    assert abs(np.sum(np.sign(data) * bits)) == len(data)
