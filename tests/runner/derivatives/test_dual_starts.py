"""What blocks fill into their buffers before the first tick: exact slopes by parameters against differences."""

from dataclasses import replace
from typing import Any

import pytest

from proofmass.blocks import HeldStateSpace, ModalReducedOrderModel, ModalResonator, SuccessiveApproximation
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.example import example_of
from proofmass.runner.derivatives.dual import slopes_of
from proofmass.runner.derivatives.dual_plan import differentiated
from proofmass.runner.planning.plan import plan


@pytest.mark.parametrize(
    ("kind", "name", "entry"),
    [
        (ModalResonator, "frequencies", 1),
        (ModalResonator, "qualities", 0),
        (ModalResonator, "masses", 1),
        (HeldStateSpace, "transition", 0),
        (HeldStateSpace, "transition", 1),
        (HeldStateSpace, "entry", 1),
        (ModalReducedOrderModel, "mass", 0),
        (ModalReducedOrderModel, "damping", 1),
        (ModalReducedOrderModel, "stiffness", 3),
        (SuccessiveApproximation, "mismatch", None),
    ],
)
def test_slopes_of_starts_against_differences(kind: type[Block], name: str, entry: int | None) -> None:
    graph = example_of(kind)
    block: Any = graph.blocks["block"]
    value = getattr(block, name)
    old = value if entry is None else value[entry]
    step = 1e-5 * (abs(old) or 1e-3)

    def at(number: float) -> dict[str, tuple[float, ...]]:
        moved = number if entry is None else (*value[:entry], number, *value[entry + 1 :])
        made = plan(graph.changed(blocks={**graph.blocks, "block": replace(block, **{name: moved})})).buffers
        return {node[1]: values for node, values in made.items() if node[0] == "block"}

    above, here, below = at(old + step), at(old), at(old - step) if old else at(old)
    width = 2.0 * step if old else step
    key = f"block.{name}" if entry is None else f"block.{name}[{entry}]"
    slopes = {
        n[1]: [slopes_of(v).get(key, 0.0) for v in held] for n, held in differentiated(plan(graph)).buffers.items()
    }
    assert any(any(slopes[buffer]) for buffer in here)
    for buffer, values in here.items():
        for k, number in enumerate(values):
            expected = (above[buffer][k] - below[buffer][k]) / width
            assert slopes[buffer][k] == pytest.approx(expected, rel=1e-4, abs=1e-8 * abs(number) / step + 1e-300)
