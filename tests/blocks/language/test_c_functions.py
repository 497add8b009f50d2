"""Functions that compiled code takes from the C library, in plain Python: against the C library itself."""

import ctypes
import ctypes.util
import itertools
import math

import pytest

from proofmass.blocks.language import arithmetic

EDGES = (-math.inf, -2.5, -2.0, -1.0, -0.5, -0.0, 0.0, 0.5, 1.0, 2.0, 3.0, 1e300, -1e300, 5e-324, math.inf, math.nan)
LIBRARY = ctypes.util.find_library("m")


@pytest.mark.skipif(LIBRARY is None, reason="no C library of mathematics by its name")
@pytest.mark.parametrize(("name", "arguments"), [("c_power", 2), ("c_remainder", 2), ("c_cube_root", 1)])
def test_at_the_edges(name: str, arguments: int) -> None:
    of_c = getattr(ctypes.CDLL(LIBRARY), arithmetic.OF_C[name])
    of_c.restype, of_c.argtypes = ctypes.c_double, [ctypes.c_double] * arguments
    for given in itertools.product(EDGES, repeat=arguments):
        found, expected = getattr(arithmetic, name)(*given), of_c(*given)
        if math.isnan(expected):
            assert math.isnan(found), given
        elif name == "c_cube_root":
            assert found == pytest.approx(expected, rel=1e-15), given
        else:
            assert (found, math.copysign(1.0, found)) == (expected, math.copysign(1.0, expected)), given
