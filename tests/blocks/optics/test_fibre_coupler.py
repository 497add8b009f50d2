"""The coupler against its matrix of complex amplitudes."""

import cmath
import math

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks.optics.fibre_coupler import FibreCoupler, cross, through


@pytest.mark.parametrize("k", [0.0, 0.2, 0.5, 1.0])
def test_against_complex_amplitudes(k: float) -> None:
    """[sqrt(1-k), j sqrt(k); j sqrt(k), sqrt(1-k)] is unitary: what one output gains the other loses."""
    p = FibreCoupler(coupling=k, transmission=0.9)
    for p1, p2, phase in ((1e-5, 0.0, 0.0), (1e-5, 4e-6, 0.7), (2e-6, 3e-6, -2.0)):
        first, second = math.sqrt(p1), math.sqrt(p2) * cmath.exp(-1j * phase)
        a = math.sqrt(1.0 - k) * first + 1j * math.sqrt(k) * second
        b = 1j * math.sqrt(k) * first + math.sqrt(1.0 - k) * second
        assert through(p, p1, p2, phase) == pytest.approx(0.9 * abs(a) ** 2, rel=1e-12, abs=1e-20)
        assert cross(p, p1, p2, phase) == pytest.approx(0.9 * abs(b) ** 2, rel=1e-12, abs=1e-20)


def test_waves_without_coherence_add_their_powers() -> None:
    p = FibreCoupler(coupling=0.3, coherence=0.0)
    assert through(p, 1e-5, 2e-5, 1.0) == pytest.approx(0.7e-5 + 0.6e-5)
    assert through(p, -1e-5, 2e-5, 1.0) == pytest.approx(0.6e-5)


@pytest.mark.derivation(
    FibreCoupler,
    equation="through = t ((1 - k) P1 + k P2 + B), B = 2 sqrt(k (1 - k) P1 P2) sin(phase)",
    source="coupled modes a' = -j kappa b, b' = -j kappa a along the fibres (time e^(+j w t)), by SciPy's exponential",
    convention="k is of power, sin(kappa z)^2; what crosses falls behind; the phase is that of the second wave ahead",
    wrong="the documents said that what crosses gains a quarter turn, which holds for time e^(-j w t) only",
)
def test_coupled_modes_along_two_fibres() -> None:
    coupled, p1, p2, phase = 0.4, 1e-5, 4e-6, 0.8
    along = linalg.expm(-1j * coupled * np.array([[0.0, 1.0], [1.0, 0.0]]))
    waves = along @ [math.sqrt(p1), math.sqrt(p2) * cmath.exp(1j * phase)]
    p = FibreCoupler(coupling=math.sin(coupled) ** 2)
    found = through(p, p1, p2, phase), cross(p, p1, p2, phase)
    assert found == pytest.approx(tuple(np.abs(waves) ** 2), rel=1e-12)
    assert sum(found) == pytest.approx(p1 + p2, rel=1e-12)
