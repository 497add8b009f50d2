"""Periodic stimuli: their peak, and where their power lies."""

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.wire_response import WireResponse
from proofmass.runner.analysis.response.stimuli import Stimulus, repetitions

EMPTY = tuple(np.zeros(shape) for shape in ((0, 0), (0, 2), (2, 0), (2, 2)))
WIRES = WireResponse(EMPTY, 1e-3)  # two values in a period of 1 ms


def test_a_binary_sequence_has_two_values_and_a_flat_spectrum() -> None:
    """Of N = 2^n - 1 bits one more is 1 than 0, and every line has the power (N + 1) / N^2."""
    (one,) = repetitions(Stimulus("prbs", 0.25, (10.0, 400.0)), WIRES, None)
    bits = one.values.reshape(one.periods, 2)
    assert (bits[:, 0] == bits[:, 1]).all(), "a bit for each period"
    assert set(one.values.tolist()) == {-0.25, 0.25}
    assert (one.periods + 1).bit_count() == 1
    assert np.sum(bits[:, 0]) == pytest.approx(0.25)
    power = np.abs(np.fft.fft(bits[:, 0]) / one.periods)[1:] ** 2
    assert power == pytest.approx(0.25**2 * (one.periods + 1.0) / one.periods**2, rel=1e-9)


@pytest.mark.parametrize("kind", ["sine", "multitone"])
def test_tones_have_their_power_at_their_lines_alone(kind: str) -> None:
    for one in repetitions(Stimulus(kind, 2.0, (10.0, 400.0)), WIRES, None):  # type: ignore[arg-type]
        assert np.max(np.abs(one.values)) == pytest.approx(2.0, rel=1e-12)
        power = np.abs(np.fft.rfft(one.values)) ** 2
        assert set(np.flatnonzero(power > 1e-12 * power.max())) == set(one.lines.tolist())
        assert (one.frequencies(1e-3) >= 10.0 - 1e-9).all()
        assert (one.frequencies(1e-3) <= 400.0 + 1e-9).all()


@pytest.mark.parametrize(("bandwidth", "highest"), [(20.0, 200.0), (100.0, 450.0)])
def test_without_a_band_it_is_that_about_the_bandwidth(bandwidth: float, highest: float) -> None:
    """From a twentieth of the bandwidth to ten times it, or to 0.9 of the 500 Hz that a period of 1 ms can tell."""
    (one,) = repetitions(Stimulus("multitone", 1.0), WIRES, bandwidth)
    frequencies = one.frequencies(1e-3)
    assert frequencies[0] == pytest.approx(bandwidth / 20.0)
    assert frequencies[-1] == pytest.approx(highest)
