"""The gain of a quantiser of one bit by an instrument: errors that go with what is quantised do not spoil it."""

import math

import numpy as np
import pytest

from proofmass.runner.analysis.decisions.compiled_decisions import Decisions
from proofmass.runner.analysis.decisions.one_bit import OneBit, _gain, _one_bit, with_spectra
from proofmass.runner.analysis.decisions.shaping import Shaping
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.derivatives.dual_noise import ONE_BIT

COUNT, LATER = 1 << 14, 5
SOURCE, OTHER = np.random.default_rng(3).normal(size=(2, COUNT))
SEEN = np.append(np.zeros(LATER), SOURCE[:-LATER])  # the source some decisions later


@pytest.mark.parametrize("size", [1.0, 1e3])
def test_an_error_that_depends_on_the_value_is_no_gain(size: float) -> None:
    """y = s + u and v = 0.5 y + 2 u: least squares have 0.5 + 2 / 2, but what s does is 0.5, in any unit of s."""
    y = SEEN + OTHER
    v = 0.5 * y + 2.0 * OTHER
    assert float(v @ y / (y @ y)) == pytest.approx(1.5, abs=0.05)
    assert _gain(y, v, [size * SOURCE]) == pytest.approx(0.5, abs=0.1)  # 2 / sqrt(16,384) is 0.016
    silent = np.zeros(COUNT)
    assert _gain(y, v, [silent, size * SOURCE]) == _gain(y, v, [size * SOURCE])


def test_of_two_sources_the_stronger_one_counts_for_more() -> None:
    """y = 3 s + u, v = 6 s + u: gains 2 and 1, with weights 9 and 1."""
    y, v = 3.0 * SOURCE + OTHER, 6.0 * SOURCE + OTHER
    assert _gain(y, v, [SOURCE, OTHER]) == pytest.approx(1.9, abs=0.05)


def test_sources_that_hardly_show_leave_least_squares() -> None:
    y = SOURCE
    v = 0.7 * y + OTHER
    assert _gain(y, v, []) == pytest.approx(float(v @ y / (y @ y)), rel=1e-12)
    apart = np.random.default_rng(4).normal(size=COUNT)
    assert _gain(y, v, [apart]) == pytest.approx(float(v @ y / (y @ y)), rel=1e-12)
    late = np.append(SOURCE[100:], np.zeros(100))  # its effect comes after 100 decisions
    assert _gain(y, v, [late]) == pytest.approx(float(v @ y / (y @ y)), rel=1e-12)
    assert _gain(np.zeros(COUNT), v, [SOURCE]) == 0.0


def test_what_short_runs_have_by_chance_is_subtracted() -> None:
    """y = 3 s + u and v = 0.5 y + 8 u, 1024 decisions: 64 lags of chance would make 0.5 + 0.05."""
    dice, found = np.random.default_rng(5), []
    for _ in range(100):
        source, other = dice.normal(size=(2, 1024))
        y = 3.0 * source + other
        found.append(_gain(y, 0.5 * y + 8.0 * other, [source]))
    assert np.mean(found) == pytest.approx(0.5, abs=0.025)  # 8 / 3 / sqrt(1024) / 10 is 0.008


def test_decisions_that_no_noise_moves() -> None:
    """A cycle where both runs repeat their decisions in spite of other values; else a gain, of one run or of two."""
    number = np.arange(1 << 13)
    repeating, other = np.where(number % 3 < 2, 1.0, -1.0), np.where(OTHER[: len(number)] < 0.0, -1.0, 1.0)
    values = repeating + 0.1 * SOURCE[: len(number)]

    def run(values: np.ndarray, levels: np.ndarray) -> Decisions:
        return Decisions(values, levels, ())

    first, free = run(values, repeating), run(values + 0.01, other)
    moved = run(values + 0.01, np.where(number % 4 < 2, 1.0, -1.0))
    found = _one_bit(first, Decisions(*(part[:-7] for part in moved)), looped=True)
    assert found == OneBit(0.0, 0.0, len(number) - 7, None, 1.0, cycle=3)
    assert _one_bit(first, moved, looped=False).cycle == 0
    still = run(np.ones(len(number)), np.ones(len(number)))
    assert _one_bit(still, still, looped=False) == OneBit(0.0, 0.0, len(number), None, 0.0)
    assert _one_bit(first, free, looped=True).cycle == 0
    alone = _one_bit(first, first, looped=True)
    assert (alone.cycle, alone.repeating) == (0, 1.0)
    shown, level = values - values.mean(), repeating - repeating.mean()
    assert alone.gain == pytest.approx(float(level @ shown / (shown @ shown)), rel=0.02)


@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_two_runs_tell_what_repeats_from_what_noise_does(size: float) -> None:
    """v = 0.5 y + r + w, of which r is the same in both runs, and twice the power of w: two thirds repeat."""
    dice = np.random.default_rng(6)
    same, repeating, *apart = dice.normal(size=(6, COUNT))
    runs = []
    for y_noise, v_noise in (apart[:2], apart[2:]):
        y = same + y_noise
        v = size * (0.5 * y + math.sqrt(2.0) * repeating + v_noise)
        runs.append(Decisions(y, v, ()))
    for looped in (True, False):
        found = _one_bit(runs[0], runs[1], looped)
        assert found.gain == pytest.approx(0.5 * size, rel=0.1)
        assert found.variance == pytest.approx(size**2, rel=0.1)
        assert found.repeating == pytest.approx(2.0 / 3.0, abs=0.05)
        assert (found.decisions, found.shaping, found.cycle) == (COUNT, None, 0)


@pytest.mark.parametrize("quantisers", [1, 2])
def test_every_decision_of_a_period_passes_the_filter_of_its_quantiser(quantisers: int) -> None:
    """The first of them has the error g / (1 - 0.5 z^-1), g^2 = 0.75: of three decisions a row is g 0.5^k."""
    first = OneBit(1.0, 1.0, 100, Shaping(math.sqrt(0.75), ((0.5, 0.0),)), 0.0)
    other = OneBit(1.0, 1.0, 100, None, 0.0)
    count = 3 * quantisers
    entries = tuple(("bit", ONE_BIT, i) for i in range(count))
    outputs = tuple(("bit", "output", i) for i in range(count))
    whole = PeriodMap((), entries, outputs, np.hstack([np.eye(count), np.zeros((count, 1))]), {}, 1e-3)
    filtered = with_spectra(whole, {"bit": (first, other)[:quantisers]})
    _, _, _, direct = filtered.parts()
    row = math.sqrt(0.75) * np.array([[1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.25, 0.5, 1.0]])
    expected = np.eye(count)
    expected[::quantisers, ::quantisers] = row
    assert direct == pytest.approx(expected)
    assert filtered.order == 1


@pytest.mark.parametrize(
    ("one", "words"),
    [
        (OneBit(0.5, 0.1, 1000, None, 0.0), "gain of 0.5, by two runs of 1,000 decisions; its error passes for white"),
        (OneBit(0.5, 0.1, 1000, Shaping(1.0, ()), 0.04), "its error has the spectrum of these runs"),
        (OneBit(0.5, 0.1, 1000, None, 0.06), "white, without 6 % of its mean square that repeat with the signals"),
        (OneBit(0.5, 0.1, 1000, None, 1.0, 0.8, 1), "with a correlation of 0.80 from one to the next"),
        (OneBit(0.5, 0.1, 1000, None, 1.0, -0.8, 3), "with a correlation of -0.80 after 3 of them"),
        (
            OneBit(0.0, 0.0, 1000, None, 1.0, cycle=7),
            "noise moves none of 1,000 decisions in two runs, which repeat after 7",
        ),
    ],
)
def test_a_note_tells_what_a_bit_counts_as(one: OneBit, words: str) -> None:
    note = one.note("bit")
    assert note.startswith("bit: ")
    assert words in note
