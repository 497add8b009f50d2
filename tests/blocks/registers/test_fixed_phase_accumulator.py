"""The phase against integers modulo a power of two, and its frequency over a long time."""

import pytest

from proofmass.blocks import FixedPhaseAccumulator
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import drive_fixed, words


@pytest.mark.parametrize(("width", "out"), [(32, 16), (24, 24), (16, 4)])
@pytest.mark.parametrize("frequency", [1000.0, -3333.3])
def test_against_integers(frequency: float, width: int, out: int) -> None:
    control = Fixed(10, 14)
    block = FixedPhaseAccumulator(frequency=frequency, width=width, control_format=control, output_bits=out)
    step, phase, expected = round(frequency * 1e-4 * 2**width), 0, []
    inputs = words(control, 300)
    for m in inputs:
        centred = (phase + (1 << width - 1)) % (1 << width) - (1 << width - 1)
        expected.append(centred >> (width - out))
        phase += step + (m << width - 14)
    rows = drive_fixed(block, [{"control": m} for m in inputs], 1e-4)
    assert [row["phase"] for row in rows] == expected


@pytest.mark.exhaustive
def test_whole_turns_in_a_second() -> None:
    """1000 Hz at 10 kHz and a quarter hertz of control: the phase is that of 250 turns and a quarter after 1/4 s."""
    block = FixedPhaseAccumulator(frequency=1000.0, control_format=Fixed(16, 31))
    small = round(0.25e-4 * 2**31)
    rows = drive_fixed(block, [{"control": small}] * 2501, 1e-4)
    assert rows[-1]["phase"] / 2**16 == pytest.approx(0.0625, abs=2**-14)
