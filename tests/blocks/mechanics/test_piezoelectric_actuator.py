"""The actuator's lines, and that what it takes and gives are one energy."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.constants import epsilon_0

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


@pytest.mark.derivation(
    PiezoelectricActuator,
    equation="F = coupling V - stiffness x, q = coupling x + capacitance V",
    source="lines of IEEE Std 176 for a stack of PZT-5H, S = s33 T + d33 E, D = d33 T + eps33 E; published k33 = 0.75",
    convention="stiffness at zero volts, capacitance at no motion; q goes into the electrode; n d33 m/V are free",
)
def test_a_stack_of_discs_by_its_material() -> None:
    """d33 = 593 pC/N, s33 = 20.7 um^2/N, eps33 = 3400 eps0 (Morgan Electro Ceramics): k33 is 0.75."""
    d33, s33, eps33, discs, thick, area = 593e-12, 20.7e-12, 3400.0 * epsilon_0, 50, 0.4e-3, 25e-6
    stiffness = area / (s33 * discs * thick)
    p = PiezoelectricActuator(
        coupling=discs * d33 * stiffness,
        stiffness=stiffness,
        capacitance=discs * area / thick * (eps33 - d33**2 / s33),
    )
    for volts, x in ((100.0, 0.0), (0.0, 2e-6), (-60.0, 3e-6)):
        field = volts / thick
        stress, density = np.linalg.solve([[s33, 0.0], [-d33, 1.0]], [x / (discs * thick) - d33 * field, eps33 * field])
        assert force(p, volts, x) == pytest.approx(-stress * area, rel=1e-9)
        assert charge(p, volts, x) == pytest.approx(discs * density * area, rel=1e-9)
    free = discs * d33 * 100.0
    assert force(p, 100.0, free) == pytest.approx(0.0, abs=1e-9 * force(p, 100.0, 0.0))
    assert 1.0 - charge(p, 100.0, 0.0) / charge(p, 100.0, free) == pytest.approx(0.75**2, rel=5e-3)
