"""The pipeline gives what the exponential of one tick gives, as many ticks later as it has rotations."""

import numpy as np
import pytest

from proofmass.blocks import FixedCordicExponential, FixedCordicExponentialPipeline
from tests.by_hand.fixed_point import drive_fixed


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize(
    ("bits", "iterations", "guard", "latency"), [(16, 16, 0, 18), (16, 18, 2, 20), (8, 3, 0, 3), (24, 40, 6, 43)]
)
def test_equal_but_for_the_latency(bits: int, iterations: int, guard: int, latency: int) -> None:
    sizes = {"fraction_bits": bits, "iterations": iterations, "guard_bits": guard}
    drawn = np.random.default_rng(3).integers(0, 2**bits, 200).tolist()
    angles = [{"angle": angle} for angle in (0, 2**bits - 1, *drawn)]
    at_once = [row["exponential"] for row in drive_fixed(FixedCordicExponential(**sizes), angles)]
    pipelined = [row["exponential"] for row in drive_fixed(FixedCordicExponentialPipeline(**sizes), angles)]
    assert pipelined[:latency] == [0] * latency
    assert pipelined[latency:] == at_once[:-latency]


def test_no_angle_fills_the_bit_above_a_register() -> None:
    """X stays below 4 - what intervals alone do not show - for all 65536 angles and at every rotation."""
    x, z = np.full(65536, 79135), np.arange(65536)
    for i in sorted([*range(1, 17), 4, 13]):
        d = np.where(z >= 0, 1, -1)
        x, z = x + d * (x >> i), z - d * round(65536 * float(np.arctanh(2.0**-i)))
        assert x.min() > 0
        assert x.max() < 4 * 65536
