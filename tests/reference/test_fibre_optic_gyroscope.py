"""The fibre-optic gyroscope of the gallery against plain Python: codes of its converters, rate and trim."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Probe
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph(library_file("fibre_optic_gyroscope.toml"))
TICKS, T = 8_000, 5e-6
SCALE = 2.0 * math.pi * 1000.0 * 0.1 / (1.55e-6 * 299_792_458.0)


def by_hand(rate: float) -> dict[str, np.ndarray]:
    """Every tick of the loop; the slope moves every second one."""
    line = slope = held = ramp = before = sample = 0.0
    trim = 7.0
    rows: dict[str, list[float]] = {"code": [], "trim": []}
    for n in range(TICKS):
        if n % 2 == 0:
            held = slope
        up = n % 2 == 0
        number = 32768.0 / (2.0 * math.pi) * (ramp + (0.25 if up else -0.25) * math.pi)
        phase = math.pi / 3.535 * trim / 32768.0 * min(max(round(number), -32768), 32767)
        difference = SCALE * rate + phase - line
        current = 0.9 * 10e-6 * (1.0 + math.cos(difference)) + 1e-9
        code = min(max(round(40e3 * current * 32768.0), -32768), 32767)
        error = (0.5 * code - 0.5 * sample) * (-1.0 if up else 1.0)
        rows["code"].append(code)
        rows["trim"].append(trim)
        if n % 2 == 0:
            slope = held - 1.7e5 * 2.0 * T * error
        trim += -0.0875 * T * error * (ramp - before)
        before, sample, line = ramp, code, phase
        ramp += held * T
        ramp -= 2.0 * math.pi * math.floor((ramp + math.pi) / (2.0 * math.pi))
    return {name: np.array(values) for name, values in rows.items()}


@pytest.mark.parametrize("rate", [10.0, -50.0])
def test_against_plain_python(rate: float) -> None:
    changed = {"detector.noisy": False, "rotation.value": math.radians(rate)}
    probes = ("adc.code", "trim.output", "mean.mean")
    probed = replace(GRAPH.with_parameters(changed), probes=tuple(map(Probe, probes)))
    result = simulate(probed, samples=TICKS, engine="compiled")
    expected = by_hand(math.radians(rate))
    same = result["adc.code"].values == expected["code"]
    assert same.mean() > 0.999, "a rounding of a phase may go the other way once in a while"
    assert result["trim.output"].values == pytest.approx(expected["trim"], abs=2e-5)
    assert result["mean.mean"].values[-1] == pytest.approx(math.radians(rate), rel=2e-5)
    assert abs(result["trim.output"].values[-1] - 7.07) < 2e-3


def test_angle_random_walk() -> None:
    """Shot and intensity noise at the bias, of a phase of 1.352 s times the rate."""
    still = GRAPH.with_parameters({"rotation.value": 0.0, "modulator.half_wave_voltage": 3.5})
    probed = replace(still, probes=(Probe("rate.output"),))
    values = simulate(probed, duration="0.41 s", engine="compiled")["rate.output"].values
    means = values[1000:41_000].reshape(-1, 100).mean(axis=1)  # of 1 ms
    density = math.sqrt(2.0 * np.mean(np.diff(means) ** 2) / 2.0 * 1e-3)  # white: Allan deviation sqrt(S / (2 tau))
    current = 9e-6
    shot, intensity = 2.0 * 1.602176634e-19 * current, 1e-13 * current**2
    steps = 32768.0 * 40e3 * 9e-6  # of the converter per radian
    rounding = 2.0 / 12.0 / 200e3 / steps**2
    expected = math.sqrt((shot + intensity) / current**2 + rounding) / SCALE
    assert density == pytest.approx(expected, rel=0.12)
