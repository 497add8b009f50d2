"""The decimator against block means."""

import numpy as np
import pytest

from proofmass.blocks import Decimator
from proofmass.blocks.declaration.instance import size_of
from tests.by_hand.functions import drive


@pytest.mark.parametrize("ratio", [1, 2, 7, 10])
def test_each_window_gives_its_mean_in_the_tick_after(ratio: int) -> None:
    inputs = np.random.default_rng(3).normal(size=8 * ratio + 1)
    rows = drive(Decimator(ratio=ratio), [{"input": u} for u in inputs.tolist()])
    means = [row["mean"] for row in rows[::ratio]]
    assert means[0] == 0.0
    assert means[1:] == pytest.approx(inputs[:-1].reshape(8, ratio).mean(axis=1), abs=1e-15)


def test_the_output_ticks_once_per_window() -> None:
    block = Decimator(ratio=25)
    assert size_of(block, type(block).outputs["mean"].every) == 25
    assert Decimator.feedthrough("mean") == ()
