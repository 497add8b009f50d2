"""Parameters of many runs at once against those of each run, to the bit."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.arithmetic.counter_random import normal_quantile
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.draws.drawing import drawn_together, normal_quantiles
from tests.by_hand.study_texts import STUDY

SPREADS: dict[str, dict[str, Any]] = {
    "normal": {"normal": "200 ppm", "relative": True},
    "truncated": {"normal": 0.3, "truncated": 1.5},
    "uniform": {"uniform": 0.1},
    "triangular": {"triangular": 0.1},
    "lognormal": {"lognormal": 0.1},
    "values": {"values": [1.0, 2.0, 4.0]},
}


@pytest.fixture
def study(tmp_path: Path) -> Study:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return read_study(path)


def assert_same(study: Study, numbers: list[int]) -> None:
    together = drawn_together(study, np.array(numbers))
    for place, number in enumerate(numbers):
        for epoch, values in enumerate(study.drawn(number)):
            assert {name: float(rows[epoch, place]).hex() for name, rows in together.items()} == {
                name: value.hex() for name, value in values.items()
            }


def test_with_sweep_and_drift(study: Study) -> None:
    assert_same(study, list(range(12)))
    assert_same(study, [7])


@pytest.mark.exhaustive("latin_hypercube-normal")
@pytest.mark.parametrize("spread", SPREADS.values(), ids=SPREADS)
@pytest.mark.parametrize("design", ["random", "latin_hypercube", "sobol"])
def test_of_every_distribution_and_design(study: Study, spread: dict[str, Any], design: str) -> None:
    given = {"source.value": spread, "adc.reference": {"normal": "1 %", "relative": True}}
    assert_same(Study(study.graph, runs=200, seed=5, design=design, spread=given), list(range(0, 200, 3)))


def test_correlated(study: Study) -> None:
    spread = {"source.value": {"normal": 0.1}, "adc.reference": {"lognormal": 0.01}}
    correlation = {"source.value": {"adc.reference": 0.7}}
    assert_same(Study(study.graph, runs=50, spread=spread, correlation=correlation), list(range(50)))


def test_runs_that_share_their_drift(study: Study) -> None:
    drift = {"adc.reference": {"random_walk": "9 ppm/sqrt(year)", "relative": True}}
    epochs = {"ages": ["0 h", "1 year"]}
    given = {"spread": {"source.value": {"uniform": 0.1}}, "drift": drift, "epochs": epochs}
    assert_same(Study(study.graph, runs=30, design="saltelli", **given), list(range(30)))


def test_quantiles_far_out_too() -> None:
    probabilities = np.concatenate([2.0 ** -np.arange(1.0, 54.0), 1.0 - 2.0 ** -np.arange(1.0, 53.0)])
    assert normal_quantiles(probabilities).tolist() == list(map(normal_quantile, probabilities.tolist()))
