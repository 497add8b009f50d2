"""One component of a vector."""

import pytest

from proofmass.blocks import VectorElement
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


@pytest.mark.parametrize("index", [0, 2, 4])
def test_the_component(index: int) -> None:
    vector = [0.5, 1.5, -2.5, 3.5, 4.5]
    (answer,) = drive(VectorElement(size=5, index=index), [{"vector": vector}], 1.0)
    assert answer["output"] == vector[index]


def test_an_index_beyond_the_vector_is_refused() -> None:
    with pytest.raises(ModelError, match="less than size = 3"):
        VectorElement(index=3)
