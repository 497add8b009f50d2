"""Phases with all their turns against the sum of what each pole, zero and delay turns."""

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.phase import counted_phase
from proofmass.runner.host.arrays import Array, Complex


class Factors:
    """A gain exp(-j w delay) times all (j w - zero), by all (j w - pole)."""

    def __init__(self, zeros: list[complex], poles: list[complex], delay: float = 0.0) -> None:
        self.zeros, self.poles, self.delay, self.asked = zeros, poles, delay, 0

    def gain(self, w: Array) -> Complex:
        self.asked += len(w)
        over, under = (np.prod([1j * w - each for each in places], axis=0) for places in (self.zeros, self.poles))
        return np.asarray(over / under * np.exp(-1j * w * self.delay))

    def phase(self, w: Array) -> Array:
        """Each factor turns by less than half a turn, the way that its place lies."""
        signs = [(1.0, zero) for zero in self.zeros] + [(-1.0, pole) for pole in self.poles]
        turned = (
            sign * (np.arctan((w - each.imag) / -each.real) - np.arctan(-each.imag / -each.real))
            for sign, each in signs
        )
        return np.asarray(sum(turned) - w * self.delay)


def pair(place: complex) -> list[complex]:
    return [place, place.conjugate()]


@pytest.mark.parametrize(
    ("factors", "most"),
    [
        (Factors(pair(-1e-5 + 2j), pair(-1.0 + 1j)), 400),
        (Factors(pair(1e-5 + 2j), pair(-1.0 + 1j)), 400),
        (Factors([*pair(1e-3 + 2.1j), *pair(-1e-3 + 5j)], [*pair(-0.1 + 1j), *pair(-2.0 + 1j)]), 600),
        (Factors([], [-1.0 + 0j], delay=300.0), 200),
        (Factors(pair(1e-4 + 3.3j), [*pair(-0.01 + 0.5j), -3.0 + 0j], delay=77.0), 600),
    ],
    ids=["a notch", "a notch that lags", "two and a resonance", "a long delay", "all of these"],
)
def test_all_turns_are_counted(factors: Factors, most: int) -> None:
    w = np.linspace(0.0, 10.0, 41)
    at_rest = 0.0 if factors.gain(w[:1])[0].real > 0.0 else np.pi
    factors.asked = 0
    assert counted_phase(factors.gain, w, factors.gain(w)) == pytest.approx(at_rest + factors.phase(w), abs=1e-9)
    assert factors.asked < most


def test_a_gain_that_is_zero_has_the_phase_before_it() -> None:
    w = np.linspace(0.0, 3.0, 4)
    found = counted_phase(lambda at: np.asarray(1j * at * (2.0 - at)), w, np.asarray(1j * w * (2.0 - w)))
    assert np.sin(found) == pytest.approx([1.0, 1.0, 1.0, -1.0])
    assert found[0] == found[1] == found[2]
    assert counted_phase(np.zeros_like, w, np.zeros(4, dtype=complex)).tolist() == [0.0] * 4


@pytest.mark.parametrize("place", [1.0, 0.7, 0.123456789])
def test_a_pole_on_the_axis_turns_by_half_a_turn(place: float) -> None:
    """Which way is not known."""
    w = np.linspace(0.0, 2.0, 21)

    def gain(at: Array) -> Complex:
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / (place**2 - at**2) + 0j)

    found = counted_phase(gain, w, gain(w))
    assert np.cos(found) == pytest.approx(np.where(w <= place, 1.0, -1.0))
    assert np.abs(found[-1]) == pytest.approx(np.pi)


@pytest.mark.defect("S981", before="+180 deg of two integrators, +90 of three", after="-180 and -270 deg")
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("delay", [0.0, 3.0])
@pytest.mark.parametrize("order", range(-3, 6))
def test_integrators_and_zeros_at_rest_turn_by_a_quarter_each(order: int, delay: float, sign: float) -> None:
    """(j w)^-n turns by -n / 4, a sign by half a turn, a delay by w times it, a pole by -atan w."""
    w = np.geomspace(1e-3, 3.0, 30)

    def gain(at: Array) -> Complex:
        return np.asarray(sign * (1j * at) ** -order * np.exp(-1j * at * delay) / (1.0 + 1j * at))

    expected = -0.5 * np.pi * order + np.pi * (sign < 0.0) - w * delay - np.arctan(w)
    assert counted_phase(gain, w, gain(w)) == pytest.approx(expected, abs=1e-9)
