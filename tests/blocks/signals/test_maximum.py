"""The larger of two signals against numpy."""

import numpy as np

from proofmass.blocks import Maximum
from tests.by_hand.responses import noise, responses


def test_against_numpy() -> None:
    first, second = [*noise(200, 1), 2.0, -1.0], [*noise(200, 2), 2.0, 1e300]
    assert responses(Maximum(), first=first, second=second) == np.maximum(first, second).tolist()
