"""The counter: exact where periods are whole ticks, and its resolution where they are not."""

import itertools
from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks import FrequencyCounter
from tests.by_hand.functions import drive

PERIOD = 1e-5


def counted(frequency: float, **parameters: bool | float) -> list[tuple[int, float]]:
    bits = [bool(np.sin(2.0 * np.pi * frequency * PERIOD * n + 0.1) >= 0.0) for n in range(50_000)]
    rows = drive(FrequencyCounter(**parameters), [{"signal": bit} for bit in bits], PERIOD)
    finished = {row["measurements"]: row["frequency"] for row in rows}
    return [(number, finished[number]) for number in sorted(finished)]


@pytest.mark.exhaustive
def test_whole_ticks_are_counted_exactly() -> None:
    (_, first), *rest = counted(1000.0)
    assert first == 0.0
    assert len(rest) in (49, 50)
    assert [value for _, value in rest] == pytest.approx([1000.0] * len(rest), rel=1e-12)


@pytest.mark.exhaustive
@pytest.mark.parametrize("frequency", [876.5, 3333.3, 12_345.6])
def test_a_reciprocal_count_is_right_to_a_tick(frequency: float) -> None:
    values = np.array([value for _, value in counted(frequency)[1:]])
    assert np.abs(values / frequency - 1.0).max() <= PERIOD / 0.01
    assert values.mean() == pytest.approx(frequency, rel=2e-5)


@pytest.mark.exhaustive
def test_a_gated_count_is_right_to_an_edge() -> None:
    values = np.array([value for _, value in counted(3333.3, reciprocal=False)[1:]])
    assert set(np.round(values, 6)) == {3300.0, 3400.0}
    assert len(values) in (49, 50)


@pytest.mark.exhaustive
def test_a_signal_that_stands_still_is_never_finished() -> None:
    assert counted(0.0) == [(0, 0.0)]


@pytest.mark.defect(
    "S651",
    before="the rise at the start counted as a period: 1023.3 Hz of a wave of 1000 Hz that begins high",
    after="a reciprocal count begins at the second rise, a gate after the first",
)
@pytest.mark.parametrize("reciprocal", [True, False])
@pytest.mark.parametrize("quiet", [1, 40, 700])
def test_the_rise_with_which_a_signal_starts_is_no_period(reciprocal: bool, quiet: int) -> None:
    """Low for a while, then a wave of 100 ticks that begins in the middle of its high half."""
    wave = [(n + 25) % 100 < 50 for n in range(5000)]
    rows = drive(FrequencyCounter(reciprocal=reciprocal), [{"signal": x} for x in [False] * quiet + wave], PERIOD)
    shown = {row["frequency"] for row in rows if row["measurements"]}
    assert sorted(shown) == pytest.approx([1000.0], rel=1e-12)


def test_the_first_gate_opens_after_the_first_rise() -> None:
    """Rises at ticks 1, 11, 21 and so on: a gate of 40 ticks holds those at 11, 21, 31 and 41."""
    rows = drive(
        FrequencyCounter(gate=40 * PERIOD, reciprocal=False), [{"signal": n % 10 == 1} for n in range(45)], PERIOD
    )
    assert next(n for n, row in enumerate(rows) if row["measurements"]) == 42
    assert rows[-1]["frequency"] == pytest.approx(4.0 / (40 * PERIOD), rel=1e-12)


@pytest.mark.derivation(
    FrequencyCounter,
    equation="reciprocal: cycles / time between their edges; gated: edges / gate",
    source="ticks of all rises of a square wave by exact fractions, grouped by hand",
    convention="whole periods, not half ones; from rise to rise; a gate of 700 ticks",
)
@pytest.mark.parametrize("frequency", [Fraction(8765, 10), Fraction(12_345, 7)])
def test_rises_in_exact_fractions(frequency: Fraction) -> None:
    """The wave starts 7/10 into a turn, so low; reciprocal counts begin at the second rise."""
    tick, gate = Fraction(1, 100_000), 700
    turns = [frequency * tick * n + Fraction(7, 10) for n in range(6000)]
    bits = [{"signal": turn % 1 < Fraction(1, 2)} for turn in turns]
    rises = [n for n, (a, b) in enumerate(itertools.pairwise(turns), 1) if a // 1 != b // 1]
    expected, begin = [], 1
    for k in range(2, len(rises)):
        if rises[k] - rises[begin] >= gate:
            expected.append(float((k - begin) / ((rises[k] - rises[begin]) * tick)))
            begin = k
    rows = drive(FrequencyCounter(gate=0.007), bits, 1e-5)
    finished = {row["measurements"]: row["frequency"] for row in rows}
    assert [finished[n] for n in range(1, max(finished) + 1)] == pytest.approx(expected[: max(finished)], rel=1e-12)
    assert len(expected) - max(finished) in (0, 1)
    rows = drive(FrequencyCounter(gate=0.007, reciprocal=False), bits, 1e-5)
    finished = {row["measurements"]: row["frequency"] for row in rows}
    gates = [sum(rises[0] + gate * i < n <= rises[0] + gate * (i + 1) for n in rises) for i in range(len(finished) - 1)]
    counted = [0.007 * finished[n] for n in range(1, len(finished))]
    assert counted == pytest.approx(gates, rel=1e-12)
