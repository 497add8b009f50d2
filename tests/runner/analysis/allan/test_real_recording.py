"""A real inertial unit at rest: spectra by SciPy, Allan deviations by the definition in rolling means of pandas."""

from pathlib import Path

import numpy as np
import pandas
import pytest
import scipy.signal

from proofmass import allan, read_series, spectrum
from proofmass.runner.analysis.allan.freedom import AllanStatistic

RECORDING = Path(__file__).parents[1] / "recordings" / "ngimu_at_rest.csv"
RATE, VALUES = 50.0, 298
COLUMNS = [f"{kind}_{axis}" for kind in ("gyroscope", "acceleration") for axis in "xyz"]


def column(name: str) -> pandas.Series:
    table = pandas.read_csv(RECORDING)
    return table[next(key for key in table.columns if key.startswith(name))]


@pytest.mark.parametrize("name", COLUMNS)
def test_spectrum(name: str) -> None:
    values = column(name)
    assert len(values) == VALUES
    frequencies, density = scipy.signal.welch(values.to_numpy(), RATE, nperseg=64)
    own = spectrum(read_series(RECORDING, name), segment=64)
    assert own.frequencies == pytest.approx(frequencies, rel=1e-9)
    assert own.density == pytest.approx(density, rel=1e-9)


@pytest.mark.exhaustive(but=2)
@pytest.mark.parametrize("name", COLUMNS)
def test_allan_deviation(name: str) -> None:
    """Half the mean square of what neighbouring means differ by, at every averaging time."""
    values = column(name)
    curve = allan(read_series(RECORDING, name)).curves[AllanStatistic.ALLAN]
    factors = np.round(curve.taus * RATE).astype(int).tolist()
    assert factors[0] == 1
    assert len(factors) > 20
    for factor, deviation in zip(factors, curve.deviation, strict=True):
        means = values.rolling(factor).mean()
        assert deviation == pytest.approx(np.sqrt(0.5 * np.mean(means.diff(factor).dropna() ** 2)), rel=1e-9)
