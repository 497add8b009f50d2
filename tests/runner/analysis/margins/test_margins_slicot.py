"""Random sampled loops against SLICOT by way of python-control: sensitivity peak and disk margin.

It runs where `slycot` is installed; the test environment does without, since python-control then takes SLICOT for
everything and `control.margin` finds no gain margin of the closed-loop accelerometer.
"""

import control
import pytest

from proofmass.runner.analysis.margins.stability import margins
from tests.by_hand.amounts import amounts
from tests.runner.analysis.margins.test_margins import by_hand, graph_of, random_case

pytest.importorskip("slycot")


@pytest.mark.parametrize("count", amounts(20, 200))
def test_peaks_of_random_loops(count: int) -> None:
    """AB13DD gives a value that |S| or |S - 1/2| has somewhere, by Hamiltonian eigenvalues instead of a grid.

    It is the largest for half of the loops; for the others a sweep of frequencies finds larger ones too.
    """
    stable = equal = 0
    for number in range(count):
        found = margins(graph_of(random_case(number)))
        if not found.stable:
            continue
        stable += 1
        sensitivity = control.feedback(1.0, by_hand(random_case(number)))
        peaks = [control.linfnorm(system)[0] for system in (sensitivity, sensitivity - 0.5)]
        assert found.sensitivity_peak is not None
        assert found.disk_margin is not None
        ratios = (found.sensitivity_peak / peaks[0], 1.0 / (found.disk_margin * peaks[1]))
        assert min(ratios) > 1.0 - 1e-8, number
        equal += max(ratios) < 1.0 + 1e-8
    assert stable >= 0.45 * count
    assert equal > 0.2 * count
