"""The convergence monitor on sequences of parameters written out."""

from typing import Any

from proofmass.blocks import ConvergenceMonitor
from tests.by_hand.functions import drive


def watched(pairs: list[tuple[float, float]]) -> list[dict[str, Any]]:
    return drive(ConvergenceMonitor(tolerance=0.01, hold=2), [{"stiffness": k, "damping": c} for k, c in pairs])


def test_done_after_enough_quiet_periods_in_a_row_and_for_good() -> None:
    pairs = [(50.0, 3.0), (51.0, 3.0), (51.1, 3.01), (51.1, 3.3), (51.1, 3.31), (51.1, 3.31), (99.0, 9.0), (0.1, 1.0)]
    rows = watched(pairs)
    assert [row["done"] for row in rows] == [False] * 6 + [True, True]
    assert [row["periods"] for row in rows] == [0, 1, 2, 3, 4, 5, 6, 6]


def test_either_parameter_alone_keeps_it_waiting() -> None:
    moving = [50.0 * 1.02**n for n in range(8)]
    assert not any(row["done"] for row in watched([(k, 3.0) for k in moving]))
    assert not any(row["done"] for row in watched([(50.0, k) for k in moving]))
