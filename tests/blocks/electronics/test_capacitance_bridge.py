"""The bridge against a solution of its nodes, and against the paper's cases."""

import numpy as np
import pytest

from proofmass.blocks import CapacitanceBridge
from tests.by_hand.functions import drive


def voltage(block: CapacitanceBridge, first: float, second: float, excitation: float = 2.0) -> float:
    (row,) = drive(block, [{"first": first, "second": second, "excitation": excitation}])
    return float(row["voltage"])


def by_nodes(p: CapacitanceBridge, first: float, second: float) -> float:
    """Both middle nodes by nodal analysis, the excitation symmetric about ground: +1/2 and -1/2 of it."""
    sensor = np.array([[first + second + p.stray]])
    middle = np.linalg.solve(sensor, [(first - second) / 2.0])[0]
    p1, p2 = p.first_reference, p.second_reference
    reference = np.linalg.solve(np.array([[p1 + p2]]), [(p1 - p2) / 2.0])[0]
    return float(middle - reference)


@pytest.mark.parametrize("stray", [0.0, 5e-12, 40e-12])
def test_against_the_charges_of_its_nodes(stray: float) -> None:
    block = CapacitanceBridge(stray=stray)
    for first, second in [(42.5e-12, 42.5e-12), (50e-12, 37e-12), (21e-12, 1e-9)]:
        assert voltage(block, first, second) == pytest.approx(2.0 * by_nodes(block, first, second), rel=1e-12)


def test_paper_cases() -> None:
    """Eq. 5: 1/2 - r at rest; eq. 16: 1 - r with the plate on the first fixed one."""
    block = CapacitanceBridge()
    r = 42.590865 / (42.590865 + 42.409135)
    assert voltage(block, 42.5e-12, 42.5e-12) == pytest.approx(2.0 * (0.5 - r), rel=1e-12)
    assert voltage(block, 1e3, 21.25e-12) == pytest.approx(2.0 * (1.0 - r), rel=1e-12)


def test_5_pf_of_stray_capacitance_take_5_6_per_cent_at_rest_and_nothing_from_an_attached_plate() -> None:
    """Limit of the paper's method (section III.A): the attached bridge does not see what moves the working gain."""

    def slope(block: CapacitanceBridge) -> float:
        return voltage(block, 42.5e-12 * 1.0001, 42.5e-12 / 1.0001) - voltage(block, 42.5e-12, 42.5e-12)

    clean, loaded = CapacitanceBridge(), CapacitanceBridge(stray=5e-12)
    assert slope(loaded) / slope(clean) - 1.0 == pytest.approx(-5.0 / 90.0, rel=1e-4)
    assert voltage(loaded, 1e3, 21.25e-12) == pytest.approx(voltage(clean, 1e3, 21.25e-12), rel=1e-12)
