"""One point of an Allan curve."""

from typing import Any

import numpy as np

from proofmass.runner.analysis.allan.deviations import integral, variance
from proofmass.runner.analysis.allan.freedom import AllanStatistic
from proofmass.runner.analysis.spectrum.series import Series


def deviation_at(statistic: AllanStatistic, values: Any, factor: int) -> float:
    """The deviation of a signal at an averaging time of so many values."""
    return float(np.sqrt(variance(statistic, integral(Series(np.asarray(values, dtype=float), 1.0)), factor)))
