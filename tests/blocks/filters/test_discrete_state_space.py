"""The system against scipy.signal.dlsim."""

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import DiscreteStateSpace
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import distance, noise, response


def random_system(order: int) -> tuple[np.ndarray, ...]:
    dice = np.random.default_rng(order)
    a = dice.normal(size=(order, order))
    a *= 0.95 / max(abs(np.linalg.eigvals(a)))
    return a, dice.normal(size=(order, 1)), dice.normal(size=(1, order)), np.array([[0.7]])


@pytest.mark.parametrize("order", [1, 2, 5, 20])
def test_against_scipy(order: int) -> None:
    a, b, c, d = random_system(order)
    u = noise(300)
    _, expected, _ = signal.dlsim((a, b, c, d, 1.0), np.array(u))
    block = DiscreteStateSpace(
        transition=a.ravel().tolist(), entry=b.ravel().tolist(), readout=c.ravel().tolist(), direct=0.7
    )
    whole, part = response(block, u), response(block, u, "strictly_proper_part")
    assert distance(whole, expected.ravel()) < 1e-12
    assert distance(np.subtract(whole, part), 0.7 * np.array(u)) < 1e-12


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"transition": (1.0, 0.0, 0.0)}, "4 numbers, as entry has 2"),
        ({"readout": (1.0,)}, "2 numbers, as entry has"),
        ({"entry": (1.0,) * 65}, "at most 64 numbers"),
    ],
)
def test_matrices_that_do_not_fit_are_refused(changes: dict[str, tuple[float, ...]], text: str) -> None:
    with pytest.raises(ModelError, match=text):
        DiscreteStateSpace(**changes)
