"""Modes that a loop of several wires does not see: the loop without them passes on what it did."""

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.margins.lifted_modes import seen
from proofmass.runner.host.arrays import Array


def loop_of(a: Array, b: Array, c: Array) -> OpenLoop:
    """An open loop of these matrices, with the sign of negative feedback."""
    states, wires = len(a), b.shape[1]
    matrix = np.block([[a, b, np.zeros((states, 1))], [-c, np.zeros((wires, wires + 1))]])
    ends = tuple((f"wire_{i}", "output", 0) for i in range(wires))
    return OpenLoop(PeriodMap(tuple((f"state_{i}", "x", -1) for i in range(states)), ends, ends, matrix, {}, 1e-3))


@pytest.mark.parametrize("mode", [1.0, -1.0])
@pytest.mark.parametrize("is_reached", [True, False], ids=["reached, not seen", "seen, not reached"])
@pytest.mark.parametrize("seed", range(3))
def test_a_neutral_mode_beside_the_loop_leaves_it_as_it_is(mode: float, is_reached: bool, seed: int) -> None:
    """It follows the other states, or moves them, and is no part of C (z - A)^-1 B; all in mixed coordinates."""
    rng = np.random.default_rng(seed)
    inner = rng.standard_normal((3, 3))
    inner *= 0.5 / np.max(np.abs(np.linalg.eigvals(inner)))
    b, c, by = 0.2 * rng.standard_normal((3, 2)), 0.2 * rng.standard_normal((2, 3)), rng.standard_normal(3)
    a = np.block([[inner, np.zeros((3, 1))], [np.zeros((1, 3)), np.array([[mode]])]])
    if is_reached:
        a[3, :3], into, out = by, np.vstack([b, rng.standard_normal(2)]), np.hstack([c, np.zeros((2, 1))])
    else:
        a[:3, 3], into, out = by, np.vstack([b, np.zeros(2)]), np.hstack([c, rng.standard_normal((2, 1))])
    mix = np.linalg.qr(rng.standard_normal((4, 4)))[0]
    rest, verdict, poles, modes = seen(loop_of(mix @ a @ mix.T, mix @ into, out @ mix.T))
    assert (verdict, len(poles), len(modes)) == ("stable", 3, 1)
    found_a, found_b, found_c, found_d = rest.matrices
    for z in np.exp(1j * np.linspace(0.3, 3.0, 5)):
        known = c @ np.linalg.solve(z * np.eye(3) - inner, b)
        assert found_c @ np.linalg.solve(z * np.eye(3) - found_a, found_b) + found_d == pytest.approx(known, abs=1e-9)
