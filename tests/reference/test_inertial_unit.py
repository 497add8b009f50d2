"""The six-axis unit of the gallery: its Allan deviation is that of its data sheet, its means those of its errors."""

import math

import numpy as np
import pytest
from scipy import stats

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph(library_file("six_axis_imu.toml"))
RATE, DURATION = 100.0, 3000.0
DEG_H = math.radians(1.0) / 3600.0
N, B, K = math.radians(0.008) / math.sqrt(2.0), 8.0 * DEG_H, 0.3 * DEG_H


@pytest.fixture(scope="module")
def long() -> Result:
    return simulate(GRAPH, duration=DURATION, engine="compiled")


def allan(values: np.ndarray, m: int) -> float:
    """Overlapping Allan deviation of averages over m samples (IEEE Std 952, annex C)."""
    angle = np.concatenate([[0.0], np.cumsum(values)]) / RATE
    second = angle[2 * m :] - 2.0 * angle[m:-m] + angle[: -2 * m]
    return math.sqrt(np.mean(second**2) / 2.0) / (m / RATE)


def interval(m: int) -> tuple[float, float]:
    """The ratio of a deviation to the true one in 99.9 % of all records, by the fewer degrees of freedom of two noises.

    Of white and of flicker noise: Riley, Handbook of Frequency Stability Analysis, NIST SP 1065.
    """
    n = round(RATE * DURATION) + 1  # values of the angle
    white = (3.0 * (n - 1) / (2.0 * m) - 2.0 * (n - 2) / n) * 4.0 * m * m / (4.0 * m * m + 5.0)
    flicker = 5.0 * n * n / (4.0 * m * (n + 3.0 * m))
    freedom = min(white, flicker)
    low, high = stats.chi2.ppf([5e-4, 1.0 - 5e-4], freedom) / freedom
    return math.sqrt(low), math.sqrt(high)


@pytest.mark.exhaustive("x-0.05", "x-1.0", "x-10.0")
@pytest.mark.parametrize("tau", [0.05, 1.0, 10.0, 60.0])
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_allan_deviation_of_the_data_sheet(axis: str, tau: float, long: Result) -> None:
    """Within what chance leaves of a record of 3000 s: 1 % at 0.05 s, 27 to 32 % at 60 s."""
    white, flicker, walk = N * N / tau, 2.0 / math.pi * math.log(2.0) * B * B, K * K * tau / 3.0
    found = allan(long[f"gyroscope_{axis}.output"].values, round(tau * RATE))
    low, high = interval(round(tau * RATE))
    assert low < found / math.sqrt(white + flicker + walk) < high


def test_noise_density_of_an_accelerometer(long: Result) -> None:
    values = long["accelerometer_y.output"].values
    assert allan(values, 5) == pytest.approx(60e-6 * 9.80665 / math.sqrt(2.0 * 0.05), rel=0.01)


def test_means(long: Result) -> None:
    """A slow turn; gravity by a misalignment of 0.05 deg, and by the sensitivity; half the square of a vibration."""
    g, angle = 9.80665, math.radians(0.05)
    mean = {signal: float(np.mean(long[signal].values)) for signal in long}
    sensitive = math.radians(1e-3)
    assert mean["gyroscope_z.output"] == pytest.approx(math.radians(1.0) + sensitive * g, abs=5.0 * B)
    assert mean["gyroscope_x.output"] == pytest.approx(angle * math.radians(1.0) + sensitive * angle * g, abs=5.0 * B)
    assert mean["accelerometer_x.output"] == pytest.approx(angle * g + 0.5 * 5e-6 * (2.0 * g) ** 2, abs=3e-4)
    assert mean["accelerometer_z.output"] == pytest.approx(g + 5e-6 * g * g, abs=3e-4)
