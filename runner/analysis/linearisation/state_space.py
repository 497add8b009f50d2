"""A linear map over a period in state space: x[n+1] = A x[n] + B u[n],  y[n] = C x[n] + D u[n]."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from proofmass.runner.host.arrays import Array, Complex

Matrices: TypeAlias = tuple[Array, Array, Array, Array]


@dataclass(frozen=True)
class SampledStateSpace:
    """A, B, C and D of a map over a period, and the period in seconds."""

    matrices: Matrices
    period: float

    @cached_property
    def poles(self) -> Complex:
        """Poles over a period."""
        return np.linalg.eigvals(self.matrices[0]).astype(complex)

    @property
    def radius(self) -> float:
        """Size of the slowest pole; below 1 the output settles."""
        return float(np.max(np.abs(self.poles), initial=0.0))

    @property
    def values(self) -> int:
        """Values of the output in a period."""
        return len(self.matrices[3])
