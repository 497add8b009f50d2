"""The oscillator: its phase is the integral of the frequency, by counting cycles and against mpmath."""

import itertools
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from scipy import special

from proofmass.blocks import NumericallyControlledOscillator
from tests.by_hand.functions import drive

PERIOD = 1e-4


def rising_zeros(values: list[float]) -> int:
    return sum(before < 0.0 <= after for before, after in itertools.pairwise(values))


@pytest.mark.defect(
    "S6", before="a Sine of driven frequency: 200 cycles", after="150 cycles from 100 Hz to 200 Hz in 1 s"
)
def test_a_ramp_from_100_to_200_hertz_makes_150_cycles_in_a_second() -> None:
    block = NumericallyControlledOscillator(frequency=100.0, initial_phase=-1e-6)
    rows = drive(block, [{"control": 100.0 * n * PERIOD} for n in range(10_001)], PERIOD)
    assert rising_zeros([row["sine"] for row in rows]) == 150


@pytest.mark.exhaustive
def test_against_mpmath_with_a_frequency_that_swings() -> None:
    block = NumericallyControlledOscillator(frequency=1234.5, gain=-40.0, amplitude=3.0, initial_phase=0.75)
    control = [math.sin(0.01 * n) for n in range(3000)]
    turns = mpmath.mpf(0.75) / (2 * mpmath.pi)
    for u, row in zip(control, drive(block, [{"control": u} for u in control], PERIOD), strict=True):
        assert abs(row["sine"] - 3 * mpmath.sinpi(2 * turns)) < 1e-11
        assert abs(row["cosine"] - 3 * mpmath.cospi(2 * turns)) < 1e-11
        assert abs(row["phase"] - 2 * mpmath.pi * (turns - mpmath.nint(turns))) < 1e-11
        turns += (mpmath.mpf(1234.5) - 40 * mpmath.mpf(u)) * mpmath.mpf(PERIOD)


def test_a_jump_of_the_frequency_is_no_jump_of_the_phase() -> None:
    control = [0.0] * 5001 + [1000.0] * 5
    rows = drive(NumericallyControlledOscillator(frequency=0.0), [{"control": u} for u in control], PERIOD)
    assert [row["phase"] for row in rows[:5002]] == [0.0] * 5002
    assert rows[5002]["phase"] == pytest.approx(2 * math.pi * 0.1)


def test_without_control_it_keeps_its_frequency() -> None:
    rows = drive(NumericallyControlledOscillator(frequency=0.25, amplitude=2.0), [{"control": 0.0}] * 8, 1.0)
    assert [row["sine"] for row in rows] == [0.0, 2.0, 0.0, -2.0] * 2
    assert [row["cosine"] for row in rows] == [2.0, 0.0, -2.0, 0.0] * 2


def test_it_breaks_a_loop_and_its_frequency_may_be_driven() -> None:
    assert NumericallyControlledOscillator.feedthrough("sine") == ()
    assert NumericallyControlledOscillator.drivable("frequency")
    assert not NumericallyControlledOscillator.drivable("initial_phase")


@pytest.mark.exhaustive
@pytest.mark.parametrize("frequency", [1234.5, 4999.9, -0.001, 3333.3])
def test_each_tick_rounds_by_as_much_as_is_said(frequency: float) -> None:
    rows = drive(NumericallyControlledOscillator(frequency=frequency), [{"control": 0.0}] * 30_001, PERIOD)
    for k in (1, 100, 30_000):
        turns = Fraction(frequency) * Fraction(PERIOD) * k
        apart = Fraction(rows[k]["phase"]) / Fraction(2.0 * math.pi) - turns
        assert abs(apart - round(apart)) <= k * Fraction(1, 2**52) + Fraction(1, 2**53)


@pytest.mark.derivation(
    NumericallyControlledOscillator,
    equation="turns[n+1] = turns[n] + T (frequency + gain control[n]), sine = amplitude sin(2 pi turns)",
    source="side lines of a frequency modulation are Bessel functions of its swing over its rate",
    convention="frequency and gain in Hz, not rad/s; amplitude is the peak; lead in rad",
)
def test_side_lines_of_frequency_modulation_are_bessel_functions() -> None:
    """1024 Hz of 32,768 a second swung by 48 Hz at 32 Hz: 1.5 of index, a line each 32 Hz."""
    rate, swing, modulation, lead = 32_768, 48.0, 32.0, 0.7
    block = NumericallyControlledOscillator(frequency=1024.0, gain=16.0, amplitude=2.5, lead=lead)
    control = [swing / 16.0 * math.cos(2.0 * math.pi * modulation * n / rate) for n in range(1024)]
    rows = drive(block, [{"control": u} for u in control], 1.0 / rate)
    lines, led = (np.fft.rfft([row[name] for row in rows]) / 512.0 for name in ("sine", "leading_sine"))
    sides = np.arange(-4, 5)
    expected = 2.5 * np.abs(special.jv(sides, swing / modulation))
    assert np.abs(lines[32 + sides]) == pytest.approx(expected, abs=2e-4)
    assert np.angle(led[32] / lines[32]) == pytest.approx(lead, abs=1e-3)
    ahead = np.arctan2([row["leading_sine"] for row in rows], [row["leading_cosine"] for row in rows])
    apart = np.exp(1j * (ahead - lead - [row["phase"] for row in rows]))
    assert apart == pytest.approx(np.ones(1024), abs=1e-12)


def test_a_phase_beyond_half_a_turn_is_within_it() -> None:
    for begun in (4.0, -5.0, 100.0):
        (row,) = drive(NumericallyControlledOscillator(initial_phase=begun), [{"control": 0.0}], PERIOD)
        assert row["phase"] == pytest.approx(math.atan2(math.sin(begun), math.cos(begun)), rel=1e-12)
