"""States scaled by powers of two, so that metres and codes in one transition matrix are of similar size.

Parlett and Reinsch, Numerische Mathematik 13, 1969, 293. LAPACK is called directly, since `scipy.linalg.matrix_balance`
takes scales beyond 2^63 for integers.
"""

from typing import Any

import numpy as np
import scipy.linalg.lapack

from proofmass.runner.host.arrays import Array

_lapack: Any = scipy.linalg.lapack
_gebal = _lapack.dgebal


def balanced(a: Array) -> tuple[Array, Array]:
    """Return S^-1 A S and the diagonal of S."""
    if len(a) < 2:
        return a, np.ones(len(a))
    value, _, _, scale, _ = _gebal(a, scale=1, permute=0)
    return value, scale
