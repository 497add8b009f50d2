"""What a solver says of its method."""

from typing import Any

import pytest

from proofmass.runner.plan.solver import Solver


@pytest.mark.parametrize(("method", "order"), [("dormand_prince", 5), ("radau", 4)])
def test_the_order_of_the_error_of_a_step(method: str, order: int) -> None:
    """h^5 of the pair of Dormand and Prince (1980), whose lesser one is of order 4.

    h^4 of the estimate of Radau IIA in Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8.
    """
    group: Any = None
    assert Solver("group", group, method, 1, 1e-6, 0.0, False).order == order
