"""The analog system of several inputs and outputs against scipy's matrix exponential."""

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks import MatrixStateSpace, Step
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import distance

INPUTS, OUTPUTS = ("first", "second", "third", "fourth"), ("one", "two", "three", "four")


@pytest.mark.parametrize(("order", "inputs", "outputs"), [(1, 1, 1), (3, 2, 4), (8, 4, 3)])
def test_steps_against_the_matrix_exponential(order: int, inputs: int, outputs: int) -> None:
    dice = np.random.default_rng(order)
    a = dice.normal(size=(order, order)) - 3.0 * np.eye(order)
    b, c, sizes = dice.normal(size=(order, inputs)), dice.normal(size=(outputs, order)), dice.normal(size=4)
    block = MatrixStateSpace(
        input_size=inputs, output_size=outputs, transition=a.ravel().tolist(), entry=b.ravel().tolist(),
        readout=c.ravel().tolist(),
    )  # fmt: skip
    graph = Graph(
        name="steps",
        rate=20,
        blocks={"system": block, **{f"step_{k}": Step(amplitude=sizes[k]) for k in range(4)}},
        wires=[f"step_{k}.output -> system.{INPUTS[k]}" for k in range(4)],
        probes=[f"system.{name}" for name in OUTPUTS],
    )
    result = simulate(graph, samples=60, engine="python")
    found = np.array([result[f"system.{name}"].values for name in OUTPUTS]).T
    rest = np.linalg.solve(a, b @ sizes[:inputs])
    expected = np.array([c @ (linalg.expm(a * n / 20.0) @ rest - rest) for n in range(60)])
    assert distance(found[:, :outputs], expected) < 1e-12
    assert not found[:, outputs:].any()


def test_matrices_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ModelError, match="4 numbers, 2 by 2"):
        MatrixStateSpace(transition=(1.0,))
    with pytest.raises(ModelError, match="n at most 8"):
        MatrixStateSpace(entry=(1.0,) * 18)
