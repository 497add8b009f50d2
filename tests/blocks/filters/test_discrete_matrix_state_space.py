"""Vectors through matrices, against numpy."""

import numpy as np
import pytest

from proofmass.blocks import DiscreteMatrixStateSpace
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_against_matrix_products() -> None:
    rng = np.random.default_rng(4)
    n, m, r = 5, 3, 2
    a, b, c, d = (rng.normal(size=shape) for shape in ((n, n), (n, m), (r, n), (r, m)))
    a /= 1.5 * np.abs(np.linalg.eigvals(a)).max()
    block = DiscreteMatrixStateSpace(
        order=n,
        input_size=m,
        output_size=r,
        transition=a.ravel().tolist(),
        entry=b.ravel().tolist(),
        readout=c.ravel().tolist(),
        direct=d.ravel().tolist(),
    )
    u = rng.normal(size=(200, m))
    rows = drive(block, [{"input": list(row)} for row in u.tolist()])
    x = np.zeros(n)
    for row, given in zip(rows, u, strict=True):
        assert row["output"] == pytest.approx(c @ x + d @ given, rel=1e-12, abs=1e-13)
        x = a @ x + b @ given


def test_matrices_of_another_size_are_refused() -> None:
    with pytest.raises(ModelError, match="6 numbers, 2 by 3"):
        DiscreteMatrixStateSpace(order=2, input_size=3, output_size=1, direct=(0.0, 0.0, 0.0))
