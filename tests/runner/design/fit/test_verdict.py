"""Readings that do not determine two exponentials: each is named; those that do are not accused."""

from typing import Any

import numpy as np
import pytest

from proofmass.runner.design.fit.data import Readings
from proofmass.runner.design.fit.fit import FitReport, fit
from proofmass.runner.design.fit.verdict import lagging, roughness
from tests.by_hand.temperature_sets import M1, M2
from tests.by_hand.temperature_sets import TEMPERATURE as T

NOISE = np.random.default_rng(11).standard_normal(61)


def verdict(temperature: Any, output: Any) -> FitReport:
    """The report, without the alternation's long way."""
    return fit(Readings("made", np.asarray(temperature), np.asarray(output), "sensor", "bias"), [], tolerance=1e-6)


def accusations(report: FitReport) -> list[str]:
    return [f"{p.key}: {p.message}" for p in report.findings if not p.note]


def notes(report: FitReport) -> str:
    return "\n".join(str(p) for p in report.findings if p.note)


@pytest.mark.exhaustive(but=5)
@pytest.mark.parametrize(
    ("output", "told"),
    [
        (1e-3 * np.exp(1.3 * T) + 1e-5 * NOISE, "a2, b2: one exponential is enough"),
        (1e-3 * np.exp(1.3 * T), "a2, b2: one exponential is enough"),
        ((1.0 - T) * np.exp(1.3 * T) + 1e-3 * NOISE, "b1, b2: the two exponents cannot be told apart"),
        ((1.0 - T) * np.exp(1.3 * T), "b1, b2: the two exponents cannot be told apart"),
        (np.exp(1.3 * T) - np.exp(1.3001 * T), "b1, b2: the two exponents cannot be told apart"),
        (3.0 * T, "b1, b2: the two exponents cannot be told apart"),
        (M1.output() + 2.5, "a1, a2: a constant is left in the output"),
        (np.exp(-1.3 * T) + 20.0, "b2: cannot be told from 0"),
        (np.exp(-1.3 * T) + 20.0 + 1e-3 * NOISE, "b2: cannot be told from 0"),
        (2.5 + 1e-4 * NOISE, "bias: does not depend on the temperature"),
        (NOISE, "bias: does not depend on the temperature"),
        (np.where(T > 1.79, 1.0, 0.0), "b1, b2: "),
        (np.sin(40.0 * T), "bias: does not depend on the temperature"),
    ],
)
def test_what_is_not_determined_is_named(output: Any, told: str) -> None:
    report = verdict(T, output)
    assert not report.determined
    assert len(accusations(report)) == 1
    assert accusations(report)[0].startswith(told)


def test_an_exponential_that_is_known_to_be_flat_acts_as_a_constant() -> None:
    """Without noise 10^-4 is known to many digits, and changes by less than a thousandth over the range."""
    report = verdict(T, np.exp(-1.3 * T) + 20.0 * np.exp(1e-4 * T))
    assert [text.partition(":")[0] for text in accusations(report)] == ["b2"]


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_the_unit_of_the_temperature_does_not_matter(scale: float) -> None:
    assert verdict(scale * T, M1.output()).determined


@pytest.mark.parametrize(
    "output",
    [
        M1.output(),
        M2.output(),
        np.exp(-6.0 * T) + 0.002 * np.exp(1.5 * T),
        np.exp(-3.0 * T) - 0.1 * np.exp(1.0 * T) + 1e-4 * NOISE,
        5.0 * M1.output() + 1e-5 * NOISE,
    ],
)
def test_what_is_determined_is_not_accused(output: Any) -> None:
    assert accusations(verdict(T, output)) == []


@pytest.mark.parametrize("output", [M1.output(), M2.output()])
def test_swapped_columns(output: Any) -> None:
    report = verdict(output, T)
    assert "look swapped" in accusations(report)[0]
    assert "--temperature 'bias' --output 'sensor'" in str(report.findings[0])


def test_the_constant_that_is_left_is_measured() -> None:
    hint = verdict(T, M1.output() + 2.5).findings[0].hint
    assert float(hint.rpartition(" ")[2]) == pytest.approx(2.5, abs=1e-4)


def test_five_readings() -> None:
    report = verdict(T[::15], M1.output()[::15])
    assert accusations(report) == ["made: 5 rows are too few to tell two exponentials from a constant"]
    assert "5 rows for 4 coefficients" in notes(report)


def test_a_large_mean_is_noted() -> None:
    assert "subtract what does not depend on the temperature with --offset" in notes(verdict(T, M2.output() + 0.01))
    assert "--offset" not in notes(verdict(T, M2.output()))


def test_repeated_rows_are_counted() -> None:
    twice = verdict(np.tile(T, 2), np.tile(M1.output(), 2))
    assert "61 of 122 rows repeat another exactly" in notes(twice)
    assert twice.determined


def test_residuals_that_hang_together_are_noted() -> None:
    wave = M1.output() + 3e-4 * np.sin(12.0 * T)
    assert "intervals are too narrow" in notes(verdict(T, wave))
    assert "intervals are too narrow" not in notes(verdict(T, M1.output()))


def test_an_alternation_that_stops_early_is_noted() -> None:
    readings = Readings("made", T, M1.output(), "sensor", "bias")
    early = fit(readings, start=(-1.0, 1.0), tolerance=1e-2)
    assert "% above the optimum after" in notes(early)
    assert early.determined
    assert "above the optimum" not in notes(fit(readings))


def test_roughness() -> None:
    assert roughness(T, T) < 0.01
    assert roughness(T, NOISE) == pytest.approx(1.0, abs=0.4)
    assert roughness(np.tile(T, 2), np.concatenate([T + 1.0, T - 1.0])) < 0.01
    assert roughness(np.append(T, T[::2]), np.append(T, T[::2])) < 0.01
    assert roughness(T, np.ones(61)) == 0.0


def test_an_alternation_that_ends_short_says_by_how_much() -> None:
    (note,) = lagging(2.0, 2.5, 1.0, 7)
    assert "ended 25 % above the optimum after 7 iterations" in note.message
    (note,) = lagging(0.0, 2.5, 1.0, 7)
    assert "inf %" in note.message
    assert lagging(2.0, 2.0, 1.0, 7) == ()
