"""Designs: strata, nets and Saltelli's matrices by their definitions, and what each does to a sum of parameters."""

from collections import Counter

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from proofmass.blocks.arithmetic.counter_random import uniform_deviate
from proofmass.graphs.studies.designs import DESIGNS, Design, permuted, stream_of

NAMES = ("adc.gain", "adc.offset", "source.value")
Table = np.ndarray[tuple[int, int], np.dtype[np.float64]]


def table(kind: str, sensors: int, seed: int = 5) -> Table:
    design = Design(kind, NAMES, sensors, seed)
    return np.array([[design.deviate(sensor, name) for name in NAMES] for sensor in range(sensors)])


@pytest.mark.parametrize("kind", DESIGNS)
def test_a_seed_counts_with_all_its_bits(kind: str) -> None:
    places = (np.floor(64.0 * table(kind, 64, seed)) for seed in (5, 4, 5 + (1 << 32), 5 + (1 << 61)))
    assert len({place.tobytes() for place in places}) == 4


def test_random_deviates_are_those_of_the_counter() -> None:
    expected = [[uniform_deviate(5, k, stream_of("spread", n), 0) for n in NAMES] for k in range(9)]
    assert table("random", 9).tolist() == expected


@pytest.mark.parametrize("sensors", [1, 2, 37, 256])
def test_a_latin_hypercube_has_one_sensor_in_each_stratum(sensors: int) -> None:
    deviates = table("latin_hypercube", sensors)
    for column in deviates.T:
        assert sorted(np.floor(column * sensors)) == list(range(sensors))
    assert (deviates > 0.0).all()
    assert (deviates < 1.0).all()


@pytest.mark.exhaustive
def test_within_its_stratum_a_deviate_is_uniform_and_parameters_are_independent() -> None:
    deviates = table("latin_hypercube", 2000)
    within = deviates * 2000 % 1.0
    assert all(stats.kstest(column, "uniform").pvalue > 0.01 for column in within.T)
    correlations = np.corrcoef(deviates.T)[np.triu_indices(3, 1)]
    assert abs(correlations).max() < 4.0 / np.sqrt(2000)


@pytest.mark.exhaustive
def test_permutations_are_equally_probable() -> None:
    counts = Counter(tuple(permuted(k, 4, 1, 3, stream) for k in range(4)) for stream in range(4800))
    assert len(counts) == 24
    assert stats.chisquare(list(counts.values())).pvalue > 0.01


def test_a_sobol_design_is_the_sequence_with_the_bits_of_a_column_turned() -> None:
    deviates = table("sobol", 64)
    plain = qmc.Sobol(3, scramble=False).random_base2(6)
    for column, points in zip(deviates.T, plain.T, strict=True):
        turned = {int(2**30 * u) ^ int(2**30 * x) for u, x in zip(column, points, strict=True)}
        assert len(turned) == 1
        assert sorted(np.floor(column * 64)) == list(range(64))
    assert table("sobol", 17).tolist() == deviates[:17].tolist()
    assert qmc.discrepancy(deviates) < 0.2 * qmc.discrepancy(table("random", 64))
    assert table("sobol", 8, seed=6).tolist() != deviates[:8].tolist()


def test_the_matrices_of_saltelli() -> None:
    deviates = table("saltelli", 23)  # four groups of five, and three of the next
    for group in range(4):
        a, b, *mixed = deviates[5 * group : 5 * group + 5]
        assert not np.intersect1d(a, b).size
        for number, row in enumerate(mixed):
            assert row.tolist() == [b[i] if i == number else a[i] for i in range(3)]
    long = table("saltelli", 5 * 64).reshape(64, 5, 3)
    both = np.hstack([long[:, 0], long[:, 1]])
    assert all(sorted(np.floor(column * 64)) == list(range(64)) for column in both.T)


@pytest.mark.exhaustive("latin_hypercube-0.05")
@pytest.mark.parametrize(("kind", "part"), [("latin_hypercube", 0.05), ("sobol", 0.2)])
def test_the_mean_of_a_sum_scatters_less_than_with_random_sensors(kind: str, part: float) -> None:
    def scatter(design: str) -> float:
        return float(np.std([table(design, 128, seed).sum(axis=1).mean() for seed in range(12)]))

    assert scatter(kind) < part * scatter("random")
