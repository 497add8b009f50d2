"""The table against sines to the nearest step, and its spurs against Nicholas and Samueli."""

import math

import numpy as np
import pytest

from proofmass.blocks import FixedPhaseAccumulator, FixedSineTable
from tests.by_hand.fixed_point import drive_fixed


@pytest.mark.exhaustive("10-20")
@pytest.mark.parametrize(("bits", "fraction"), [(3, 8), (6, 14), (10, 20)])
def test_every_phase(bits: int, fraction: int) -> None:
    block = FixedSineTable(phase_bits=bits, fraction_bits=fraction)
    words = range(-(1 << bits - 1), 1 << bits - 1)
    rows = drive_fixed(block, [{"phase": u} for u in words])
    for u, row in zip(words, rows, strict=True):
        angle = 2.0 * math.pi * (u + 0.5) / 2**bits
        assert row["sine"] == round(math.sin(angle) * 2**fraction)
        assert row["cosine"] == round(math.cos(angle) * 2**fraction)


@pytest.mark.exhaustive
@pytest.mark.parametrize(("bits", "step"), [(6, 37), (6, 40), (8, 100)])
def test_spurs_of_a_cut_phase(bits: int, step: int) -> None:
    """Six or four bits of twelve are cut off: the worst line is 36 or 48 dB below the carrier."""
    x = math.pi * math.gcd(step, 1 << 12 - bits) / (1 << 12 - bits)
    assert worst_line(bits, step) == pytest.approx(2.0**-bits * x / math.sin(x) / (1 - 2.0**-bits), rel=3e-3)


@pytest.mark.exhaustive
def test_no_spurs_where_the_step_has_zeros_below() -> None:
    assert worst_line(8, 96) < 1e-8


def worst_line(bits: int, step: int) -> float:
    """Largest line beside the carrier, over the carrier; a whole period of the register has each in one bin."""
    rate = 4096.0
    accumulator = FixedPhaseAccumulator(frequency=float(step), width=12, output_bits=bits)
    phases = [row["phase"] for row in drive_fixed(accumulator, [{"control": 0}] * 4096, 1.0 / rate)]
    table = FixedSineTable(phase_bits=bits, fraction_bits=30)
    values = [row["sine"] for row in drive_fixed(table, [{"phase": u} for u in phases])]
    lines = np.abs(np.fft.rfft(np.array(values, dtype=float)))
    carrier = lines[step]
    lines[step] = 0.0
    return float(lines.max() / carrier)
