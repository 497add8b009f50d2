"""States scaled by powers of two, so that metres and codes in one transition matrix are of similar size.

Parlett and Reinsch, Numerische Mathematik 13, 1969, 293. LAPACK is called directly, since
`scipy.linalg.matrix_balance` takes scales beyond 2^63 for integers.
"""

from typing import Any

import numpy as np
import scipy.linalg.lapack

from proofmass.runner.host.arrays import Array

_lapack: Any = scipy.linalg.lapack
_gebal = _lapack.dgebal


def balanced(a: Array, b: Array | None = None, c: Array | None = None) -> tuple[Array, Array]:
    """Return S^-1 A S and the diagonal of S.

    With B and C what enters and leaves counts too, as one more state with a unit of its own: of a
    state that A alone hardly holds, as what is gone after a period, A's rounding would say the
    unit.
    """
    n = len(a)
    if b is None or c is None:
        if n < 2:
            return a, np.ones(n)
        value, _, _, scale, _ = _gebal(a, scale=1, permute=0)
        return value, scale
    joined = np.zeros((n + 1, n + 1))
    joined[:n, :n] = a
    joined[:n, n], joined[n, :n] = np.linalg.norm(b, axis=1), np.linalg.norm(c, axis=0)
    _, _, _, scale, _ = _gebal(joined, scale=1, permute=0)
    own = scale[:n] / scale[n]
    return a * own / own[:, None], own
