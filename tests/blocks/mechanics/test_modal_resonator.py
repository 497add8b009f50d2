"""Each mode against scipy's exact step of its matrix, from hardly damped to overdamped."""

from contextlib import nullcontext

import mpmath
import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import ModalResonator
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.mechanics.modal_resonator import decayed
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


@pytest.mark.parametrize("apart", [0.0, 1e-14, -1e-13, 3e-12, -1e-10, 1e-7, -1e-7, 1e-5, -1e-3, 0.3, -0.3])
def test_near_critical_damping_by_mpmath(apart: float) -> None:
    """Damping a little above or below w: e^(-d T) cos(r T) and e^(-d T) sin(r T) / r, r^2 = w^2 - d^2."""
    w, period = 300.0, 7e-3
    d = w * (1.0 + apart)
    with mpmath.workdps(50):
        r = mpmath.sqrt(mpmath.mpf(w) ** 2 - mpmath.mpf(d) ** 2)
        fall = mpmath.exp(-mpmath.mpf(d) * mpmath.mpf(period))
        expected = fall * mpmath.cos(r * period), fall * mpmath.sinc(r * period) * period
    found = decayed(w, d, period)
    assert found[0] == pytest.approx(float(mpmath.re(expected[0])), rel=1e-11)
    assert found[1] == pytest.approx(float(mpmath.re(expected[1])), rel=1e-9)


def test_lists_of_unlike_length_are_refused() -> None:
    with pytest.raises(ModelError, match="1 numbers, as frequencies has"):
        ModalResonator(frequencies=(1.0,))


@pytest.mark.derivation(
    ModalResonator,
    equation="m_i (q_i'' + w_i / Q_i q_i' + w_i^2 q_i) = a_i F, displacement = sum of b_i q_i",
    source="d'Alembert's solution of a rod with one free end: a step of pull and its echoes",
    convention="modal mass belongs to the shape: half the rod's where the free end moves by 1; f in Hz, not rad/s",
)
@pytest.mark.parametrize("place", [1.0, 0.25])
def test_a_rod_that_is_pulled_at_its_end(place: float) -> None:
    """A step F of pull sends a wave of the speed F c / (E A) along; its echoes add up, ten times the length."""
    length, speed, area_modulus, pull, count = 0.03, 6000.0, 2e4, 5.0, 60
    k = 2.0 * np.arange(1, count + 1) - 1.0
    ends = np.sin(k * np.pi / 2.0)
    rod = ModalResonator(
        frequencies=(k * speed / (4.0 * length)).tolist(),
        qualities=[1e12] * count,
        masses=[area_modulus / speed**2 * length / 2.0] * count,
        force_shape=ends.tolist(),
        readout_shape=np.sin(k * np.pi / 2.0 * place).tolist(),
    )
    period = length / speed / 40.0
    found = response(rod, [pull] * 400, "displacement", "force", period)

    t, expected = np.arange(400) * period * speed, np.zeros(400)
    for echo in range(6):  # from the wall with the other sign, from the free end with its own
        there, back = ((2 * echo + 1 - place) * length, (2 * echo + 1 + place) * length)
        expected += (-1.0) ** echo * (np.maximum(t - there, 0.0) - np.maximum(t - back, 0.0))
    assert distance(found, pull / area_modulus * expected) < 0.01


@pytest.mark.parametrize(("modes", "refused"), [(64, False), (65, True)])
def test_64_modes_are_taken(modes: int, refused: bool) -> None:
    names = ("frequencies", "qualities", "masses", "force_shape", "readout_shape")
    with pytest.raises(ModelError, match="at most 64 numbers") if refused else nullcontext():
        ModalResonator(**dict.fromkeys(names, (1.0,) * modes))
