"""The dot product against NumPy."""

import numpy as np
import pytest

from proofmass.blocks import DotProduct
from tests.by_hand.functions import drive
from tests.by_hand.responses import noise


@pytest.mark.parametrize("size", [1, 3, 40])
def test_against_numpy(size: int) -> None:
    weights, vectors = noise(size, 1), np.array(noise(5 * size, 2)).reshape(5, size)
    block = DotProduct(weights=tuple(weights))
    answers = [row["output"] for row in drive(block, [{"vector": v} for v in vectors.tolist()], 1.0)]
    assert answers == pytest.approx(vectors @ np.array(weights), abs=1e-13)
