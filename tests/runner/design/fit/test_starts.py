"""Both methods from a grid of starts: who arrives, and that nobody claims it falsely."""

from itertools import combinations

import pytest

from proofmass.runner.design.fit.fit import fit
from proofmass.runner.design.fit.starts import GRID, from_starts
from tests.by_hand.temperature_sets import M1, M2, fitted


@pytest.mark.exhaustive
def test_alternation_and_projection_of_m1() -> None:
    report = fitted(M1)
    alternated, projected = from_starts(report, GRID[::3])
    assert [arrival.start for arrival in alternated.all] == [arrival.start for arrival in projected.all]
    assert len(alternated.all) == len(list(combinations(GRID[::3], 2)))
    rising = [arrival for arrival in alternated.all if arrival.start[1] > 0.0]
    assert len(rising) == len(alternated.all) - 1  # from two falling exponentials the last bits of a machine decide
    assert all(arrival.reached for arrival in rising)
    assert min(arrival.iterations for arrival in rising) > 1000
    assert max(arrival.iterations for arrival in projected.all if arrival.reached) < 50


@pytest.mark.exhaustive
@pytest.mark.parametrize("device", [M1, M2])
def test_who_does_not_arrive_says_so(device: object) -> None:
    readings = M1.readings() if device is M1 else M2.readings()
    report = fit(readings, tolerance=1e-3)
    alternated, projected = from_starts(report, (-1.2, -0.6, -0.3, 0.6))
    optimum = report.fits[0].rmse
    for arrival in (*alternated.all, *projected.all):
        assert arrival.rmse >= optimum * (1.0 - 1e-9)
        assert arrival.reached == (arrival.converged and arrival.rmse <= optimum * (1.0 + 1e-6))
    assert sum(arrival.reached for arrival in projected.all) == len(projected.all) - 1


def test_a_start_is_in_units_of_the_temperature() -> None:
    report = fit(M1.readings(), tolerance=1.0)
    assert from_starts(report, (-0.6, 0.6))[0].all[0].start == pytest.approx((-1.0, 1.0))
