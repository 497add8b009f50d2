"""The pipeline against exact quantising, whatever its thresholds, and its gain errors against an independent chain."""

import math

import numpy as np
import pytest

from proofmass.blocks import PipelineAnalogToDigital
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import response

VOLTS = np.linspace(-0.97, 0.97, 997).tolist()


@pytest.mark.parametrize("threshold_errors", [(0.0,), (0.2, -0.2, 0.15)])
def test_thresholds_do_not_matter(threshold_errors: tuple[float, ...]) -> None:
    block = PipelineAnalogToDigital(stages=5, last_bits=3, threshold_errors=threshold_errors)
    found = np.array(response(block, VOLTS, "code", "voltage"))
    assert np.abs(found - np.array(VOLTS) * 128.0).max() <= 0.5 + 1e-9
    assert response(block, VOLTS, "number", "voltage") == found.tolist()


def test_gain_errors_against_a_chain_of_residues() -> None:
    errors = (0.01, -0.02)
    block = PipelineAnalogToDigital(stages=4, last_bits=2, gain_errors=errors)
    expected = []
    for v in VOLTS:
        residue, code = v, 0
        for k in range(4):
            d = (residue > 0.25) - (residue < -0.25)
            residue = (1.0 + (errors[k] if k < 2 else 0.0)) * (2.0 * residue - d)
            code += d * 2 ** (5 - 1 - k)
        expected.append(min(max(code + round(2.0 * residue), -32), 31))
    assert response(block, VOLTS, "code", "voltage") == expected


def test_devices_differ_by_their_spread() -> None:
    """Of the first stage alone: the jump of the code at a threshold is 2^(bits-1) e / 4 steps, both sides of zero."""
    ends = [
        response(PipelineAnalogToDigital(stages=1, last_bits=4, gain_spread=0.05, device=k), [0.24], "code", "voltage")[
            0
        ]
        for k in range(200)
    ]
    assert np.std(ends) == pytest.approx(0.05 * 0.48 * 8.0, rel=0.6)
    assert len(set(ends)) > 1


def test_beyond_the_span_and_too_many_errors() -> None:
    assert response(PipelineAnalogToDigital(), [5.0, -5.0], "code", "voltage") == [2047, -2048]
    with pytest.raises(ModelError, match="at most 1 numbers"):
        PipelineAnalogToDigital(stages=1, gain_errors=(0.0, 0.0))
    assert math.isfinite(response(PipelineAnalogToDigital(), [1e300], "number", "voltage")[0])


@pytest.mark.defect(
    "S678",
    before="a gain error of the first stage bent nothing: the code had a slope of 1 + e, and no jump",
    after="jumps of e 2^(bits-2) steps at its thresholds: 5 steps of 12 bits at half a percent",
)
@pytest.mark.derivation(
    PipelineAnalogToDigital,
    equation="residue' = (1 + e) (2 residue - d r), number = sum of d_k 2^(bits-1-k) + the last code",
    source="charges of a stage of two capacitors: an amplifier of gain A loses 2 / A of all that it sums, d r too",
    convention="reference is half the span; e is of the residue amplifier as a whole, a loss is negative; k from 1",
    wrong="S678: e was of 2 residue alone, so that errors of the first stage were no INL",
)
def test_an_amplifier_of_low_gain_makes_jumps() -> None:
    """Both sample v; then one feeds back and one goes to d r: 2 x - out - d r = -2 v, out = -A x, x at its input."""
    gain, reference, bits = 400.0, 0.8, 12
    error = 1.0 / (1.0 + 2.0 / gain) - 1.0
    block = PipelineAnalogToDigital(stages=bits - 4, last_bits=4, reference=reference, gain_errors=(error,))
    volts = np.linspace(-0.9, 0.9, 4001) * reference
    digits = np.where(volts > 0.25 * reference, 1.0, np.where(volts < -0.25 * reference, -1.0, 0.0))
    charges = np.array([2.0 * volts - digits * reference, 0.0 * volts])
    residues = np.linalg.solve([[1.0, -2.0], [1.0, gain]], charges)[0]
    steps = 0.5 * (digits * reference + residues) * 2 ** (bits - 1) / reference
    found = np.array(response(block, volts.tolist(), "code", "voltage"))
    assert np.abs(found - steps).max() <= 0.51
    bent = found - volts * 2 ** (bits - 1) / reference
    place = np.searchsorted(volts, 0.25 * reference)
    assert bent[place + 1] - bent[place - 2] == pytest.approx(-error * 2 ** (bits - 2), abs=1.1)
    assert -error * 2 ** (bits - 2) == pytest.approx(5.1, abs=0.1)


def test_a_threshold_error_moves_both_thresholds_up() -> None:
    """A jump, which a gain error makes, shows where they are."""
    block = PipelineAnalogToDigital(stages=8, last_bits=4, gain_errors=(-0.02,), threshold_errors=(0.1,))
    volts = np.linspace(-0.5, 0.5, 2001)
    bent = np.array(response(block, volts.tolist(), "code", "voltage")) - volts * 2048.0
    jumps = volts[1:][np.diff(bent) > 10.0]
    assert jumps == pytest.approx([-0.15, 0.35], abs=1e-3)
