"""The table against SciPy's interpolator on a grid."""

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from proofmass.blocks import SurfaceTable
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, responses

XS, YS = (-1.0, 0.5, 2.0, 2.5), (0.0, 1.0, 4.0)
VALUES = noise(12, 3)


def test_against_scipy() -> None:
    block = SurfaceTable(first_breakpoints=XS, second_breakpoints=YS, values=tuple(VALUES))
    x, y = np.array(noise(300, 1, 2.0)), np.array(noise(300, 2, 3.0))
    expected = RegularGridInterpolator((XS, YS), np.reshape(VALUES, (4, 3)))(
        np.column_stack([np.clip(x, -1.0, 2.5), np.clip(y, 0.0, 4.0)])
    )
    assert responses(block, first=x.tolist(), second=y.tolist()) == pytest.approx(expected, abs=1e-13)


def test_its_points_are_exact() -> None:
    block = SurfaceTable(first_breakpoints=XS, second_breakpoints=YS, values=tuple(VALUES))
    x, y = np.meshgrid(XS, YS, indexing="ij")
    assert responses(block, first=x.ravel().tolist(), second=y.ravel().tolist()) == pytest.approx(VALUES, abs=1e-15)


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(ModelError, match="6 of them"):
        SurfaceTable(first_breakpoints=(0.0, 1.0), second_breakpoints=(0.0, 1.0, 2.0), values=(1.0,) * 5)
    with pytest.raises(ModelError, match="each above"):
        SurfaceTable(first_breakpoints=(0.0, 0.0))
