"""The sampled analog system against scipy's exact step, of many states and of states with units far apart."""

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import HeldStateSpace
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive
from tests.by_hand.responses import distance

PERIOD = 1e-5


def resonators(count: int) -> tuple[np.ndarray, ...]:
    """Masses in a chain, displacements in m and velocities in m/s, of 10 to 40 kHz; two forces, two readouts, D."""
    chain = 2.0 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    zero, stiffness = np.zeros((count, count)), (2.0 * np.pi * 20e3) ** 2 * chain
    a = np.block([[zero, np.eye(count)], [-stiffness, -1e-7 * stiffness]])
    b = np.zeros((2 * count, 2))
    b[count, 0] = b[-1, 1] = 1e8
    c = np.zeros((2, 2 * count))
    c[0, 0] = c[1, count - 1] = 1e6
    return a, b, c, np.array([[0.0, 0.1], [0.0, 0.0]])


@pytest.mark.parametrize("count", [1, 10])
def test_against_scipy(count: int) -> None:
    a, b, c, d = resonators(count)
    block = HeldStateSpace(
        order=2 * count, input_size=2, output_size=2, transition=a.ravel().tolist(), entry=b.ravel().tolist(),
        readout=c.ravel().tolist(), direct=d.ravel().tolist(),
    )  # fmt: skip
    forces = np.random.default_rng(1).normal(size=(200, 2))
    ad, bd, _, _, _ = signal.cont2discrete((a, b, c, d), PERIOD)
    x, expected, proper = np.zeros(2 * count), [], []
    for u in forces:
        expected.append(c @ x + d @ u)
        proper.append(c @ x)
        x = ad @ x + bd @ u
    rows = drive(block, [{"input": u.tolist()} for u in forces], PERIOD)
    assert distance([row["output"] for row in rows], expected) < 1e-10
    assert distance([row["strictly_proper_part"] for row in rows], proper) < 1e-10


def test_matrices_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ModelError, match="4 numbers, 2 by 2"):
        HeldStateSpace(transition=(1.0,))
