"""Filters with the spectrum of a series, against those that made the series, and the test for white noise."""

import numpy as np
import pytest
import scipy.integrate
import scipy.signal

from proofmass.runner.analysis.decisions.shaping import Shaping, is_white, shaping

FILTER = Shaping(0.3, ((0.98 + 0.1j, 0.9), (-0.4 + 0j, 0.0), (0.2 + 0.7j, 0.5)))


def polynomials(of: Shaping) -> tuple[np.ndarray, np.ndarray]:
    """Numerator and denominator by powers of z^-1."""
    both = [(p, zero) for pole, zero in of.poles for p in {pole, pole.conjugate()}]
    return of.gain * np.poly([zero for _, zero in both]).real, np.poly([p for p, _ in both]).real


def test_states_of_a_filter_are_unrelated_and_its_response_is_that_of_the_poles() -> None:
    a, b, c, d = FILTER.matrices()
    assert a @ a.T + b @ b.T == pytest.approx(np.eye(len(a)), abs=1e-12)
    impulse = np.zeros(60)
    impulse[0] = 1.0
    wanted = scipy.signal.lfilter(*polynomials(FILTER), impulse)
    answer = [d[0, 0], *((c @ np.linalg.matrix_power(a, n) @ b)[0, 0] for n in range(59))]
    assert np.array(answer) == pytest.approx(wanted, abs=1e-11)


def test_values_of_a_period_are_those_of_the_filter() -> None:
    a, b, c, d = FILTER.over(7)
    white = np.random.default_rng(1).normal(size=35)
    x, out = np.zeros(len(a)), []
    for first in range(0, 35, 7):
        u = white[first : first + 7]
        out.append(c @ x + d @ u)
        x = a @ x + b @ u
    wanted = scipy.signal.lfilter(*polynomials(FILTER), white)
    assert np.concatenate(out) == pytest.approx(wanted, abs=1e-11)


def test_spectrum_of_a_series_is_found() -> None:
    """Of a rise at low frequencies, a resonance and a notch: within 0.8 dB, and rms 1."""
    maker = Shaping(1.0, ((0.995 + 0j, 0.9), (0.1 + 0.9j, 0.0), (0.0 + 0j, -0.8)))
    values = scipy.signal.lfilter(*polynomials(maker), np.random.default_rng(2).normal(size=1 << 19))
    fitted = shaping(values)
    f = np.geomspace(3e-4, 0.49, 40)
    apart = 10.0 * np.log10(fitted.density(f) * np.var(values) / maker.density(f))
    assert np.max(np.abs(apart)) < 0.8
    whole = scipy.integrate.trapezoid(fitted.density(np.linspace(0.0, 0.5, 100_001)), dx=0.5e-5)
    assert 2.0 * whole == pytest.approx(1.0, rel=0.01)


def test_white_noise_passes_and_other_noise_fails() -> None:
    white = np.random.default_rng(3).normal(size=(50, 1 << 14))
    assert sum(map(is_white, white)) >= 49
    assert not is_white(scipy.signal.lfilter([1.0, 0.1], [1.0], white[0]))
    assert not is_white(white[0] + 0.02 * np.cumsum(white[1]))
    assert is_white(np.zeros(100))
