"""What a checker of certificates takes: factors up to the limit of a claim, and none that end before."""

from typing import Any

import mpmath
import numpy as np
import pytest

from proofmass.runner.verification.proof_checker import ONE, FalseCertificateError, _check_ends, _factors, _holds

GAIN = {"kind": "gain margin", "limit": 6.0, "factor": "gain"}  # 10^0.3 is 1.99526
PHASE = {"kind": "phase margin", "limit": 60.0, "factor": "phase"}  # pi / 3 is 1.047198
DELAY = {"kind": "delay margin", "limit": 1.5e-3, "factor": "phase", "period": 1e-3}  # 1.5 pi is 4.712389
DISK = {"kind": "disk margin", "limit": 0.5, "factor": "disk"}
STABLE = {"kind": "stable", "limit": 0.0, "factor": "gain"}
DECAY = {"kind": "decay rate", "limit": 3.0, "factor": "gain", "period": 1e-3}


@pytest.mark.parametrize(
    ("claim", "low", "high"),
    [
        (GAIN, 0.5011, 1.9953),
        (PHASE, 0.0, 1.0472),
        (PHASE, -0.1, 1.0472),
        (DELAY, 0.0, 4.7124),
        ({**DELAY, "limit": 9.0}, 0.0, 6.2832),
        (DISK, 0.5, 0.5),
        (DISK, 0.6, 0.6),
        (STABLE, 1.0, 1.0),
        (DECAY, 1.0, 1.0),
    ],
)
def test_factors_up_to_the_limit_will_do(claim: dict[str, Any], low: float, high: float) -> None:
    _check_ends({**claim, "ends": [low, high]}, "here")


@pytest.mark.parametrize(
    ("claim", "low", "high"),
    [
        (GAIN, 0.5013, 1.9953),
        (GAIN, 0.5011, 1.9952),
        ({**GAIN, "factor": "phase"}, 0.5011, 1.9953),
        ({**GAIN, "limit": -1.0}, 0.5, 2.0),
        (PHASE, 1e-9, 1.0472),
        (PHASE, 0.0, 1.0471),
        ({**PHASE, "factor": "gain"}, 0.0, 1.0472),
        (DELAY, 1e-9, 4.7124),
        (DELAY, 0.0, 4.7123),
        ({**DELAY, "period": 0.0}, 0.0, 6.2832),
        ({**DELAY, "limit": 9.0}, 0.0, 6.2831),
        (DISK, 0.5, 0.6),
        (DISK, 0.49, 0.49),
        ({**DISK, "factor": "gain"}, 0.5, 0.5),
        ({**STABLE, "limit": 1.0}, 0.5, 2.0),
        (STABLE, 1.1, 1.2),
        (STABLE, 0.8, 0.9),
        ({**DECAY, "period": -1e-3}, 1.0, 1.0),
    ],
)
def test_factors_that_end_before_the_limit_prove_nothing(claim: dict[str, Any], low: float, high: float) -> None:
    with pytest.raises(FalseCertificateError, match="its factors are not those of the claim"):
        _check_ends({**claim, "ends": [low, high]}, "here")


@pytest.mark.parametrize("ends", [(2.0, 1.0), (0.0, float("inf")), (float("nan"), 1.0)])
def test_sides_without_ends_are_refused(ends: tuple[float, float]) -> None:
    with pytest.raises(FalseCertificateError, match="without ends"):
        _check_ends({**GAIN, "ends": ends}, "here")


@pytest.mark.defect("S801", before="0.95 / 0.9 was below one: two errors that add up counted as one", after="refused")
@pytest.mark.parametrize(("middle", "shorter"), [(0.85, False), (0.79, True)])
def test_what_is_unknown_of_a_matrix_and_of_a_norm_add_up(middle: float, shorter: bool) -> None:
    """X = diag(0.9, 1) stands for the norm of Euclid; of [0, b / 0.9; b, 0] the first is known up to 0.1 / 0.9."""
    part = ONE // 1000
    unit, b = np.eye(2, dtype=object) * ONE, int(1000 * middle) * part
    x = np.array([[900 * part, 0], [0, ONE]], dtype=object)
    matrix = np.array([[[0, b * 10 // 9], [b, 0]], [[0, ONE // 9], [0, 0]]], dtype=object)
    largest = float(matrix[0, 0, 1] + matrix[1, 0, 1]) / float(ONE)
    assert (largest < 1.0) == shorter
    assert _holds(matrix, unit, (x, x @ unit), ONE, False, 2) == shorter


def test_a_factor_lies_within_its_radius_of_the_rounded_one() -> None:
    (found,) = _factors("phase", (0.7, 0.7), 1)
    with mpmath.workdps(200):
        c, s = mpmath.cos(mpmath.mpf(0.7)) * ONE, mpmath.sin(mpmath.mpf(0.7)) * ONE
        apart = [abs(one - int(middle)) for one, middle in zip((c, -s, s, c), found[0].flat, strict=True)]
        assert max(apart) <= found[1].min()
