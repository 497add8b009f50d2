"""Spreads against the distributions of SciPy, by Kolmogorov and Smirnov with fixed seeds."""

from typing import Any

import numpy as np
import pytest
from scipy import stats

from proofmass.blocks.arithmetic.counter_random import uniform_deviate
from proofmass.blocks.declaration.problem import Refusal
from proofmass.graphs.studies.distributions import read_spread

SIZE = 4000


def drawn(table: dict[str, Any], nominal: float, stream: int = 5) -> list[float]:
    spread = read_spread(table, "V")
    return [spread.at(nominal, uniform_deviate(77, run, stream, 0)) for run in range(SIZE)]


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ({"normal": "20 mV"}, stats.norm(2.0, 0.02)),
        ({"normal": "1 %", "relative": True}, stats.norm(2.0, 0.02)),
        ({"normal": 0.1, "truncated": 1.5}, stats.truncnorm(-1.5, 1.5, 2.0, 0.1)),
        ({"uniform": "0.5 V"}, stats.uniform(1.5, 1.0)),
        ({"triangular": 0.25, "relative": True}, stats.triang(0.5, 1.5, 1.0)),
        ({"lognormal": 0.3}, stats.lognorm(0.3, scale=2.0)),
    ],
)
def test_against_scipy(table: dict[str, Any], expected: Any) -> None:
    values = drawn(table, 2.0)
    assert stats.kstest(values, expected.cdf).pvalue > 0.01
    wider = stats.norm(2.0, 1.1 * np.std(values))
    assert stats.kstest(values, wider.cdf).pvalue < 0.01 or table.get("normal") is None


PARTS = [1e-12, 1e-4, 0.2, 0.499, 0.5, 0.7, 0.9999, 1.0 - 1e-12]


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ({"normal": 0.1}, stats.norm(2.0, 0.1)),
        ({"normal": 0.1, "truncated": 1.5}, stats.truncnorm(-1.5, 1.5, 2.0, 0.1)),
        ({"normal": 0.1, "truncated": 9.0}, stats.norm(2.0, 0.1)),
        ({"uniform": "0.5 V"}, stats.uniform(1.5, 1.0)),
        ({"triangular": 0.5}, stats.triang(0.5, 1.5, 1.0)),
        ({"lognormal": 0.3}, stats.lognorm(0.3, scale=2.0)),
    ],
)
def test_quantiles_against_scipy(table: dict[str, Any], expected: Any) -> None:
    spread = read_spread(table, "V")
    assert [spread.at(2.0, part) for part in PARTS] == pytest.approx(expected.ppf(PARTS), rel=1e-10)


def test_weights() -> None:
    table = {"values": ["1 V", "2 V", "3500 mV", "4 V"], "weights": [1, 3, 0, 4]}
    counts = np.unique(drawn(table, 2.0), return_counts=True)
    assert counts[0].tolist() == [1.0, 2.0, 4.0]
    assert stats.chisquare(counts[1], np.array([1, 3, 4]) * SIZE / 8).pvalue > 0.01


def test_values_are_equally_probable() -> None:
    counts = np.unique(drawn({"values": ["1 V", "2 V", "3500 mV"]}, 2.0), return_counts=True)
    assert counts[0].tolist() == [1.0, 2.0, 3.5]
    assert stats.chisquare(counts[1]).pvalue > 0.01


def test_streams_and_runs_are_independent() -> None:
    first, second = drawn({"normal": 1.0}, 0.0, 5), drawn({"normal": 1.0}, 0.0, 6)
    assert abs(np.corrcoef(first, second)[0, 1]) < 4 / np.sqrt(SIZE)
    assert abs(np.corrcoef(first[1:], first[:-1])[0, 1]) < 4 / np.sqrt(SIZE)


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"uniform": 1.0, "truncated": 2}, "truncated"),
        ({"normal": 1.0, "truncated": 0.01}, "truncated"),
        ({"values": [1.0], "relative": True}, "relative"),
        ({"lognormal": 0.1, "relative": True}, "relative"),
        ({"normal": 1.0, "relative": 1}, "relative"),
        ({"normal": True}, "normal"),
        ({"normal": float("inf")}, "normal"),
        ({"normal": 10**400}, "normal"),
        ({"values": []}, "values"),
        ({"values": [1.0, 2.0], "weights": [1.0]}, "weights"),
        ({"values": [1.0, 2.0], "weights": [1.0, -1.0]}, "weights"),
        ({"values": [1.0, 2.0], "weights": [0.0, 0.0]}, "weights"),
        ({"normal": 1.0, "weights": [1.0]}, "weights"),
        ({"normal": 1.0, "column": "offset"}, "column"),
        (3, ""),
        ({}, ""),
    ],
)
def test_mistakes(table: Any, key: str) -> None:
    with pytest.raises(Refusal) as caught:
        read_spread(table, "V")
    assert caught.value.key == key
