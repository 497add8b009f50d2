"""The sign against numpy."""

import numpy as np

from proofmass.blocks import Sign
from tests.by_hand.responses import noise, response


def test_against_numpy() -> None:
    signal = [*noise(200), 0.0, -0.0, 5e-324, -5e-324, 1e308]
    assert response(Sign(), signal) == np.sign(signal).tolist()
