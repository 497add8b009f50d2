"""The actuator's lines, and that what it takes and gives are one energy."""

from itertools import pairwise

import pytest

from proofmass.blocks.mechanics.piezoelectric_actuator import PiezoelectricActuator, charge, force


def test_both_lines() -> None:
    p = PiezoelectricActuator(coupling=2.0, stiffness=3.0, capacitance=0.5)
    assert (force(p, 5.0, 7.0), charge(p, 5.0, 7.0)) == (2.0 * 5.0 - 3.0 * 7.0, 2.0 * 7.0 + 0.5 * 5.0)


def test_a_cycle_of_work_is_paid_for_by_the_charge() -> None:
    """Around a closed path of (V, x) the integrals of F dx and V dq are the same: nothing is made or lost."""
    p = PiezoelectricActuator(stiffness=40.0)
    path = [(0.0, 0.0), (30.0, 0.0), (30.0, 2e-6), (-5.0, 3e-6), (0.0, 0.0)]
    work = given = 0.0
    for (v0, x0), (v1, x1) in pairwise(path):
        work += 0.5 * (force(p, v0, x0) + force(p, v1, x1)) * (x1 - x0)
        given += 0.5 * (v0 + v1) * (charge(p, v1, x1) - charge(p, v0, x0))
    assert work == pytest.approx(given, rel=1e-12)
    assert work != 0.0
