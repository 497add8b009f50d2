"""The analog system against scipy's matrix exponential, at every order."""

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks import StateSpace, Step
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import distance


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_a_step_against_the_matrix_exponential(order: int) -> None:
    dice = np.random.default_rng(order)
    a = dice.normal(size=(order, order)) - 2.0 * np.eye(order)
    b, c = dice.normal(size=order), dice.normal(size=order)
    block = StateSpace(transition=a.ravel().tolist(), entry=b.tolist(), readout=c.tolist(), direct=0.5)
    graph = Graph(
        name="step",
        rate=20,
        blocks={"step": Step(amplitude=2.0), "system": block},
        wires=["step.output -> system.input"],
        probes=["system.output"],
    )
    found = simulate(graph, samples=60, engine="python")["system.output"].values
    rest = np.linalg.solve(a, b)
    expected = [2.0 * (c @ (linalg.expm(a * n / 20.0) @ rest - rest) + 0.5) for n in range(60)]
    assert distance(found, expected) < 1e-12


@pytest.mark.parametrize(
    ("changes", "text"),
    [({"transition": (1.0,)}, "4 numbers, as entry has 2"), ({"entry": (1.0,) * 5}, "at most 4 numbers")],
)
def test_matrices_that_do_not_fit_are_refused(changes: dict[str, tuple[float, ...]], text: str) -> None:
    with pytest.raises(ModelError, match=text):
        StateSpace(**changes)
