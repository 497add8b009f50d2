"""A loop that is lost rests at zero, and the others go on."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from proofmass.runner.design.modulators.simulation import output_of


def test_a_lost_loop_rests_at_zero() -> None:
    """x' = 2 x + u and y = -x: of u = -1 is y = 0, 1, 3 ... 63, which is beyond 50; of u = 0 all is zero."""
    structure: Any = SimpleNamespace(order=1, stepped=lambda k: (np.array([[2.0, 1.0, 0.0]]), np.array([-1.0, 0.0])))
    inputs = np.column_stack([np.full(20, -1.0), np.zeros(20), np.full(20, 1.0)])
    out, swings, lost = output_of(structure, None, inputs, 2)  # type: ignore[arg-type]
    assert lost.tolist() == [True, False, True]
    assert swings.tolist() == [[63.0, 0.0, 63.0]]
    assert (out[:, :2] == 1.0).all()
    assert out[:, 2].tolist() == [1.0, *[-1.0] * 6, *[1.0] * 13], "zero counts as positive"
