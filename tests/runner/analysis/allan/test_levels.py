"""N, B, K and Q of synthetic signals: within their own intervals of 95 % as often as these say."""

import math

import numpy as np
import pytest
from scipy.stats import binom

from proofmass import Series
from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit, word_of
from proofmass.runner.analysis.allan.levels import allan_terms, density_terms, fitted, matched
from tests.by_hand.amounts import amounts

PERIOD, COUNT = 0.1, 20_000
TRUE = {"N": 0.1, "B": 0.05, "K": 0.01}


def flicker(random: np.random.Generator, level: float) -> np.ndarray:  # type: ignore[type-arg]
    """A piece of a long signal with the two-sided density B^2 / (2 pi f)."""
    count = 8 * COUNT
    f = np.fft.rfftfreq(count, PERIOD)[1:]
    size = np.sqrt(level**2 / (np.pi * f) * count / PERIOD / 4.0)
    lines = size * (random.normal(size=len(f)) + 1j * random.normal(size=len(f)))
    return np.asarray(np.fft.irfft(np.concatenate([[0.0], lines]), count)[:COUNT])


def signal(random: np.random.Generator) -> Series:
    white = random.normal(size=COUNT) * TRUE["N"] / math.sqrt(PERIOD)
    walk = np.cumsum(random.normal(size=COUNT)) * TRUE["K"] * math.sqrt(PERIOD)
    return Series(white + flicker(random, TRUE["B"]) + walk, PERIOD)


@pytest.mark.parametrize("seeds", amounts(10, 100))
def test_intervals_hold_the_truth_in_95_of_100(seeds: int) -> None:
    random = np.random.default_rng(1)
    found = [fitted(signal(random)) for _ in range(seeds)]
    for name, true in TRUE.items():
        inside = sum(one[name].low <= true <= one[name].high for one in found)
        assert inside >= binom.ppf(0.01, seeds, 0.95), name
        assert np.median([one[name].value for one in found]) == pytest.approx(true, rel=0.1 * math.sqrt(100 / seeds))
    assert sum(one["Q"].seen for one in found) <= 0.1 * seeds


def test_quantisation_of_the_integral() -> None:
    """A counter that hands out whole steps of an angle: Q is step / sqrt(12)."""
    random = np.random.default_rng(4)
    angle = np.cumsum(random.normal(size=50_001) * 3.0)
    found = fitted(Series(np.diff(np.round(angle)) / 0.01, 0.01))
    assert found["Q"].low <= 1.0 / math.sqrt(12.0) <= found["Q"].high
    assert found["N"].low <= 3.0 / math.sqrt(0.01) <= found["N"].high


def test_a_density_of_known_coefficients_is_matched() -> None:
    frequencies = np.geomspace(1e-4, 4.9, 300)
    squares = np.array([0.1**2, 0.05**2, 0.01**2, 0.02**2])
    found = matched(frequencies, density_terms(frequencies, PERIOD) @ squares, PERIOD)
    assert [level.value for level in found.levels] == pytest.approx([0.1, 0.05, 0.01, 0.02], rel=1e-6)
    assert found.misfit < 1e-6


def test_allan_variances_are_integrals_of_the_densities() -> None:
    """With 2 sin^4 / (m sin)^2; flicker in the limit of many values, the others for any number of them."""
    f = (np.arange(400_000) + 0.5) / 400_000 * 0.5 / PERIOD
    m = 50
    weight = 2.0 * np.sin(np.pi * f * m * PERIOD) ** 4 / (m * np.sin(np.pi * f * PERIOD)) ** 2
    integrals = (density_terms(f, PERIOD) * weight[:, None]).sum(axis=0) * (f[1] - f[0])
    terms = allan_terms(np.array([m * PERIOD]))[0]
    assert integrals[[0, 3]] == pytest.approx(terms[[0, 3]], rel=1e-6)
    assert integrals[2] == pytest.approx(terms[2], rel=1e-3)
    assert integrals[1] == pytest.approx(terms[1], rel=2e-2)


@pytest.mark.defect("S1003", before="of a rate in °/s, `white noise`", after="angle random walk, in deg/√h")
@pytest.mark.parametrize(("unit", "deg"), [("°/s", 1.0), ("°/h", 3600.0), ("deg/s", 1.0)])
def test_a_rate_in_degrees_is_one_however_they_are_written(unit: str, deg: float) -> None:
    assert word_of("N", unit) == "angle random walk"
    assert word_of("K", unit) == "rate random walk"
    assert field_unit("N", unit) == "deg/sqrt(h)"
    assert in_field_unit("N", 0.01 * deg, unit) == pytest.approx(0.6, rel=1e-12)
    assert in_field_unit("B", 0.01 * deg, unit) == pytest.approx(36.0, rel=1e-12)


@pytest.mark.parametrize(
    ("quantity", "unit", "value", "number", "shown"),
    [
        ("N", "rad/s", math.radians(0.1) / 60.0, 0.1, "deg/sqrt(h)"),
        ("N", "deg/s", 0.1 / 60.0, 0.1, "deg/sqrt(h)"),
        ("B", "rad/s", math.radians(1.0) / 3600.0, 1.0, "deg/h"),
        ("K", "rad/s", math.radians(1.0) / 3600.0 / 60.0, 1.0, "deg/(h*sqrt(h))"),
        ("N", "m/s^2", 0.02 / 60.0, 0.02, "m/(s*sqrt(h))"),
        ("B", "g0", 5e-6, 5.0, "ug0"),
        ("density", "m/s^2", 9.80665e-5, 10.0, "ug0/sqrt(Hz)"),
        ("N", "V", 3e-6, 3e-6, "V/sqrt(Hz)"),
        ("K", "1/s", 2.0, 2.0, "(1/s)/sqrt(s)"),
    ],
)
@pytest.mark.friendly(31, "in units of data sheets")
def test_units_of_data_sheets(quantity: str, unit: str, value: float, number: float, shown: str) -> None:
    assert field_unit(quantity, unit) == shown
    assert in_field_unit(quantity, value, unit) == pytest.approx(number, rel=1e-12)


def test_words_of_data_sheets() -> None:
    assert word_of("N", "rad/s") == "angle random walk"
    assert word_of("N", "m/s^2") == "velocity random walk"
    assert word_of("N", "V") == "white noise"
    assert word_of("B", "Hz") == "bias instability"


@pytest.mark.defect("C410", before="ZeroDivisionError", after="intervals around the values, and by how much they miss")
@pytest.mark.parametrize("line", [3.7, 12.5, 31.0])
def test_a_vibration_line_is_told_as_what_it_is(line: float) -> None:
    """A sine ten times as strong as the white noise beside it, at 200 Hz for 5 s."""
    t = np.arange(1000) / 200.0
    noise = 1e-3 * np.random.default_rng(5).normal(size=1000)
    found = fitted(Series(1e-2 * np.sin(2.0 * math.pi * line * t) + noise, 1.0 / 200.0))
    assert all(level.low <= level.value <= level.high < math.inf for level in found.levels)
    assert found.misfit > 2.0  # dB


def test_the_interval_of_white_noise_is_that_of_its_independent_lines() -> None:
    """The density of n lines is known to 1.96 / sqrt(n), by Hann's window to sqrt(35 / 18) times that; N to half.

    That other noises may be there too makes it wider, less than twice.
    """
    count = 4000
    found = fitted(Series(np.random.default_rng(2).normal(size=count), 1.0))["N"]
    half = 0.5 * 1.96 * math.sqrt(35.0 / 18.0 / (0.5 * count))
    assert 0.9 * half < found.high / found.value - 1.0 < 2.0 * half
    assert 0.9 * half < 1.0 - found.low / found.value < 2.0 * half
