"""The search against all codes of a weighted ladder, the ideal converter, and the INL that statistics foretell."""

import math

import numpy as np
import pytest

from proofmass.blocks import SuccessiveApproximation
from proofmass.blocks.arithmetic.bit_weights import bit_weights
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, response


def test_the_ideal_one_finds_the_nearest_code() -> None:
    volts = [*noise(500, 1, 1.5), -2.5, 2.5, 9.0, -9.0]
    found = response(SuccessiveApproximation(bits=10), volts, "code", "voltage")
    expected = [min(max(math.floor(v / 2.5 * 512.0 + 0.5), -512), 511) for v in volts]
    assert found == expected
    assert response(SuccessiveApproximation(bits=10), volts, "number", "voltage") == expected


def test_wrong_weights_against_the_greedy_sum() -> None:
    """Of all codes the one that a greedy search over exact weights keeps."""
    errors = (0.01, -0.02, 0.0, 0.03)
    weights = np.array([8.0, 4.0, 2.0, 1.0]) * (1.0 + np.array(errors))
    volts = np.linspace(-1.0, 0.99, 301)
    found = response(
        SuccessiveApproximation(bits=4, reference=1.0, bit_errors=errors), volts.tolist(), "code", "voltage"
    )
    for v, code in zip(volts, found, strict=True):
        level, bits = v * 8.0 + 8.0 + 0.5, [(code + 8) >> (3 - i) & 1 for i in range(4)]
        for i in range(4):
            reached = level - weights[:i] @ bits[:i] >= weights[i]
            assert bits[i] == int(reached)


def test_the_spread_of_devices_is_that_of_unit_elements() -> None:
    """Where the highest bit takes over from all others, 2 sqrt(2^(bits-1)) s / sqrt(2), in steps (Razavi)."""
    bits, mismatch = 10, 0.01
    steps = []
    for device in range(400):
        weights = bit_weights(bits, (), mismatch, device)
        steps.append(weights[0] - sum(weights[1:]) - 1.0)
    assert np.std(steps) == pytest.approx(mismatch * math.sqrt(2.0**bits - 1.0), rel=0.1)
    assert abs(np.mean(steps)) < 4.0 * np.std(steps) / math.sqrt(400.0)


def test_noise_moves_the_code() -> None:
    assert SuccessiveApproximation(noise=1e-3) != SuccessiveApproximation()
    quiet, loud = SuccessiveApproximation(bits=16), SuccessiveApproximation(bits=16, noise=1e-3)
    assert response(loud, [0.0], "code", "voltage") == response(quiet, [0.0], "code", "voltage")  # a deviate of zero


def test_too_many_errors_are_refused() -> None:
    with pytest.raises(ModelError, match="at most 2 numbers"):
        SuccessiveApproximation(bits=2, bit_errors=(0.0,) * 3)


@pytest.mark.derivation(
    SuccessiveApproximation,
    equation="bit i is kept where (v + reference) / lsb + 1/2 >= weights kept so far + w_i, w_i = 2^i (1 + error_i)",
    source="charge that is not lost on the top plate of a binary row of capacitors, trial by trial",
    convention="reference is half the span; weights in ideal steps, the same where their sum is the ideal one",
)
def test_charge_redistribution_on_a_row_of_capacitors() -> None:
    """Bottoms at v while it samples, then at the span's ends; half a step is given to the plate beforehand."""
    bits, reference, errors = 6, 1.6, (-0.02, 0.03, 0.0, 0.08, 0.0, -0.16)
    row = [2.0**i * (1.0 + e) for i, e in zip(range(bits - 1, -1, -1), errors, strict=True)]
    whole = sum(row) + 1.0
    assert whole == pytest.approx(64.0)
    volts, expected = np.linspace(-1.7, 1.7, 341).tolist(), []
    for v in volts:
        charge, kept = -(v + reference / 64.0) * whole, []
        for i in range(bits):
            bottoms = [reference if bit else -reference for bit in [*kept, True]] + [-reference] * (bits - 1 - i)
            plate = (charge + sum(c * u for c, u in zip(row, bottoms, strict=True)) - reference) / whole
            kept.append(plate <= 0.0)
        expected.append(int("".join(str(int(bit)) for bit in kept), 2) - 32)
    block = SuccessiveApproximation(bits=bits, reference=reference, bit_errors=errors)
    found = response(block, volts, "code", "voltage")
    assert sum(a != b for a, b in zip(found, expected, strict=True)) <= 1  # of a tie
    assert len(set(expected)) < 64  # some are missing
