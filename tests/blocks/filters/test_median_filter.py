"""The median against scipy.signal, with values that repeat and spikes."""

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import MedianFilter
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, response


@pytest.mark.parametrize("length", [1, 3, 5, 51])
@pytest.mark.parametrize("digits", [0, 12])
def test_against_scipy(length: int, digits: int) -> None:
    u = np.round(noise(600), digits)
    centred = signal.medfilt(np.concatenate([np.zeros(length), u]), length)
    late = centred[length - length // 2 : 600 + length - length // 2]
    found = response(MedianFilter(length=length), u.tolist(), "median")
    assert found[: len(late) - length] == late[: len(late) - length].tolist()


def test_a_spike_vanishes_and_an_edge_stays() -> None:
    u = [0.0] * 5 + [9.0, 9.0] + [0.0] * 5 + [1.0] * 6
    assert response(MedianFilter(length=5), u, "median") == [0.0] * 14 + [1.0] * 4


@pytest.mark.parametrize("length", [2, 4])
def test_an_even_length_is_refused(length: int) -> None:
    with pytest.raises(ModelError, match="an odd number"):
        MedianFilter(length=length)
