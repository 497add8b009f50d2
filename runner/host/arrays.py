"""Types of arrays of numbers."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Integers = npt.NDArray[np.int64]
Truths = npt.NDArray[np.bool_]
AnyArray = np.ndarray[Any, np.dtype[Any]]
