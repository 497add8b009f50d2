"""The smaller of two signals against numpy."""

import numpy as np

from proofmass.blocks import Minimum
from tests.by_hand.responses import noise, responses


def test_against_numpy() -> None:
    first, second = [*noise(200, 1), 2.0, -1.0], [*noise(200, 2), 2.0, 1e300]
    assert responses(Minimum(), first=first, second=second) == np.minimum(first, second).tolist()
