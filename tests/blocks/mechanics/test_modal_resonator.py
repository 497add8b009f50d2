"""Each mode against scipy's exact step of its matrix, from hardly damped to overdamped."""

from contextlib import nullcontext

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import ModalResonator
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import distance, noise, response

MODES = {
    "frequencies": (100.0, 830.0, 2100.0, 50.0),
    "qualities": (1e4, 0.5, 3.0, 0.2),
    "masses": (1e-3, 2e-4, 1e-5, 1e-2),
    "force_shape": (1.0, -0.5, 0.3, 1.0),
    "readout_shape": (0.4, 1.0, 2.0, -1.0),
}


@pytest.mark.parametrize("output", ["displacement", "velocity"])
def test_against_scipy(output: str) -> None:
    forces, period = noise(400), 2e-4
    expected = np.zeros(400)
    for f, q, m, a, b in zip(*MODES.values(), strict=True):
        w = 2.0 * np.pi * f
        row = [b, 0.0] if output == "displacement" else [0.0, b]
        system = (
            np.array([[0.0, 1.0], [-w * w, -w / q]]),
            np.array([[0.0], [a / m]]),
            np.array([row]),
            np.zeros((1, 1)),
        )
        ad, bd, cd, _, _ = signal.cont2discrete(system, period)
        x = np.zeros(2)
        for n, u in enumerate(forces):
            expected[n] += (cd @ x)[0]
            x = ad @ x + bd[:, 0] * u
    found = response(ModalResonator(**MODES), forces, output, "force", period)
    assert distance(found, expected) < 1e-10


def test_lists_of_unlike_length_are_refused() -> None:
    with pytest.raises(ModelError, match="1 numbers, as frequencies has"):
        ModalResonator(frequencies=(1.0,))


@pytest.mark.parametrize(("modes", "refused"), [(64, False), (65, True)])
def test_64_modes_are_taken(modes: int, refused: bool) -> None:
    names = ("frequencies", "qualities", "masses", "force_shape", "readout_shape")
    with pytest.raises(ModelError, match="at most 64 numbers") if refused else nullcontext():
        ModalResonator(**dict.fromkeys(names, (1.0,) * modes))
