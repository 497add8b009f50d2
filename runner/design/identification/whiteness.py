"""Tests whether residuals are white: Ljung and Box, Biometrika 65, 1978, 297."""

from dataclasses import dataclass

import numpy as np
import scipy.special

from proofmass.runner.host.arrays import AnyArray

LAGS = 20
SIGNIFICANT = 0.01


@dataclass(frozen=True)
class Whiteness:
    """Autocorrelation of residuals at lags 1 to 20, and the chance that white ones look so."""

    autocorrelation: AnyArray
    chance: float

    @property
    def white(self) -> bool:
        """True if nothing speaks against it."""
        return self.chance >= SIGNIFICANT

    @property
    def widening(self) -> float:
        """Factor of too small standard errors if the residuals are what they look like."""
        if self.white:
            return 1.0
        return float(np.sqrt(max(1.0 + 2.0 * float(np.sum(self.autocorrelation)), 1.0)))


def whiteness(residuals: AnyArray) -> Whiteness:
    """Return the test of one row of residuals."""
    values = residuals - np.mean(residuals)
    size, lags = len(values), min(LAGS, len(residuals) // 4)
    total = float(values @ values)
    if lags < 1 or total == 0.0:
        return Whiteness(np.zeros(0), 1.0)
    rho = np.array([float(values[lag:] @ values[:-lag]) / total for lag in range(1, lags + 1)])
    statistic = size * (size + 2.0) * float(np.sum(rho**2 / (size - np.arange(1, lags + 1))))
    return Whiteness(rho, float(scipy.special.chdtrc(lags, statistic)))
