"""What a loop does not see leaves its quotient as often above as below."""

from typing import Any

import flint
import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.poles import Pole, Variation
from proofmass.runner.analysis.linearisation.rational import Transfer, roots
from proofmass.runner.analysis.margins.modes import _unseen, seen

Z = flint.fmpz_poly([0, 1])
NEAR = flint.fmpz_poly([2**80 + 1, -(2**81), 2**80])  # zeros 1 + j 2^-40 and 1 - j 2^-40
REAL = (2**40 * (Z - 1) - 1) * (Z - 1) * 2**40  # zeros 1 + 2^-40 and 1
SLOW = 4 * Z - 3
TURNING = 5 * Z * Z - 6 * Z + 5  # zeros 0.6 + 0.8j and 0.6 - 0.8j


@pytest.mark.parametrize(
    ("above", "below"),
    [(NEAR, REAL), (REAL, NEAR), (NEAR, NEAR), (REAL, REAL + 1), (2**80 * TURNING, 2**80 * TURNING + 1)],
)
def test_pairs_and_single_zeros_next_to_each_other(above: Any, below: Any) -> None:
    """z - 0.9 over (z - 0.5)(z - 0.75), times two zeros on the circle in either, some of them pairs of conjugates."""
    numerator, denominator = above * (10 * Z - 9), below * (2 * Z - 1) * SLOW * 10
    closed = numerator + denominator
    entries = [int(c) / int(closed[4]) for c in closed.coeffs()]
    companion = np.vstack([np.eye(len(entries) - 1)[1:], [-c for c in entries[:-1]]])
    part = np.zeros((len(companion), 1))
    matrix = np.block([[companion, part, part], [part.T, np.zeros((1, 2))]])
    variation = Variation(np.full_like(companion, 1e-6), np.zeros(1, dtype=complex), np.zeros(1))
    states, wire = tuple(("x", "s", i) for i in range(4)), (("x", "y", 0),)
    system = OpenLoop(PeriodMap(states, wire, wire, matrix, {}, 1.0), variation=variation)
    transfer, verdict, _, _ = seen(system, Transfer(numerator, denominator))
    ends = transfer.numerator, transfer.denominator
    left = [sorted(complex(root).real for root in roots(end)) for end in ends]
    assert left[0] == pytest.approx([0.9], abs=1e-9)
    assert left[1] == pytest.approx([0.5, 0.75], abs=1e-9)
    assert verdict == "stable"
    value = _value(transfer.numerator) / _value(transfer.denominator)
    assert float(value) == pytest.approx((0.25 - 0.9) / (8.0 * (0.25 - 0.5) * (0.25 - 0.75)), rel=1e-9)


def _value(polynomial: Any) -> Any:
    """Return it at z = 1/4, exactly."""
    return polynomial(flint.fmpq(1, 4))


@pytest.mark.parametrize(
    ("apart", "row", "uncertainty", "hidden"),
    [
        (0.0, 1.0, 0.0, True),
        (0.9e-9, 0.1, 0.0, True),
        (1.1e-9, 0.1, 0.0, False),  # small rows do not count as 1: what is left of it is seen
        (0.9e-5, 1e4, 0.0, True),  # of rows with large numbers, rounding leaves more
        (1.1e-5, 1e4, 0.0, False),
        (0.9e-5, 1.0, 1e-6, True),  # ten times what the pole is uncertain by
        (1.1e-5, 1.0, 1e-6, False),
    ],
)
def test_a_state_that_an_output_does_not_show(apart: float, row: float, uncertainty: float, hidden: bool) -> None:
    """Of two modes at a right angle, the second one lies next to the pole, and shows nothing."""
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    a, c = turn @ np.diag([0.5, 0.75 + apart]) @ turn.T, row * turn[None, :, 0]
    found = _unseen(a, c, Pole(0.75, 0.25, uncertainty), 1)
    assert found == pytest.approx([0.6, 0.8] if hidden else [0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize(
    ("c", "hidden"), [([0.0, 1.0], [1.0, 0.0]), ([1.0, 0.0], [0.0, 0.0]), ([0.0, 0.0], [1.0, 1.0])]
)
def test_a_chain_of_two_states_with_one_pole(c: list[float], hidden: list[float]) -> None:
    """x' = p x + y, y' = p y: y alone does not show x; x shows y a tick later."""
    found = _unseen(np.array([[0.75, 1.0], [0.0, 0.75]]), np.array([c]), Pole(0.75, 0.25, 0.0), 2)
    assert found == pytest.approx(hidden, abs=1e-12)
