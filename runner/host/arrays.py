"""Types of arrays of numbers, and arrays that cannot be changed."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Integers = npt.NDArray[np.int64]
Truths = npt.NDArray[np.bool_]
AnyArray = np.ndarray[Any, np.dtype[Any]]


def read_only(values: AnyArray) -> AnyArray:
    """Return a view of an array that cannot be changed, so that what is told of the numbers stays true."""
    kept = values.view()
    kept.flags.writeable = False
    return kept
