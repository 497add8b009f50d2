"""What the low-g accelerometer makes of a recorded earthquake: the figures that the graph's description states."""

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.simulate import simulate

GRAPH = library_file("recorded_motion.toml")
MILLI_G = 9.80665e-3


def test_resolution_of_the_mean_and_of_the_code() -> None:
    result = simulate(read_graph(GRAPH), engine="compiled")
    motion = result["motion.output"].values  # the recording, straight lines between its samples
    recorded = np.loadtxt(GRAPH.with_suffix(".csv"), delimiter=",", skiprows=12)[:, 1]
    assert np.abs(motion[: len(recorded)] - recorded).max() < 1e-12
    window = ((motion[:-1] + motion[1:]) / 2.0).reshape(-1, 2).mean(axis=1)  # 10 ms, as the decimator's
    seen = result["mean.mean"].values[1:]
    error = (seen - window) / MILLI_G
    time = np.arange(len(window)) * 0.01
    quiet, tremor, strong = time < 2.2, (time >= 2.25) & (time < 2.8), time >= 9.0
    assert 0.1 < error[quiet].std() < 0.3  # the mean is good to 0.2 mg
    assert (window[tremor] / MILLI_G).std() == pytest.approx(0.27, abs=0.01)
    assert np.corrcoef(window[tremor], seen[tremor])[0, 1] > 0.5  # the first tremor just shows
    assert np.abs(window).max() / MILLI_G > 190.0
    assert error[strong].std() < 0.7  # the strong motion is followed
    assert abs(error.mean()) < 0.05


def test_one_code_is_1_4_milli_g() -> None:
    graph = read_graph(GRAPH)
    p = graph.blocks
    volts = p["readout"].gain * p["accelerometer"].mass / p["accelerometer"].stiffness  # type: ignore[attr-defined]
    code = 2.0 * p["adc"].reference / 2 ** p["adc"].bits / volts  # type: ignore[attr-defined]
    assert code / MILLI_G == pytest.approx(1.386, abs=0.001)
    assert p["scale"].gain == pytest.approx(code, rel=1e-5)  # type: ignore[attr-defined]
