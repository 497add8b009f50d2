"""The table against numpy.interp, at and beyond its ends."""

import numpy as np
import pytest

from proofmass.blocks import LookUpTable
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import distance, noise, response

BREAKPOINTS = sorted(noise(41, 3))
VALUES = noise(41, 4)


@pytest.mark.parametrize("length", [2, 3, 5, 41])
def test_against_numpy_between_and_beyond(length: int) -> None:
    knots, levels = BREAKPOINTS[:length], VALUES[:length]
    signal = [*noise(2000, 5, 1.5), *knots, -100.0, 100.0]
    answer = response(LookUpTable(breakpoints=knots, values=levels), signal)
    assert distance(answer, np.interp(signal, knots, levels)) < 1e-13
    assert [answer[-2], answer[-1]] == [levels[0], pytest.approx(levels[-1], abs=1e-15)]


def test_lines_at_the_ends_go_on_where_that_is_asked_for() -> None:
    block = LookUpTable(breakpoints=(0.0, 1.0, 2.0), values=(0.0, 2.0, 3.0), extrapolated=True)
    assert response(block, [-1.0, 0.5, 1.5, 4.0]) == [-2.0, 1.0, 2.5, 5.0]


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"breakpoints": (0.0,), "values": (1.0,)}, "two or more, each above the one before"),
        ({"breakpoints": (0.0, 1.0, 1.0)}, "two or more, each above the one before"),
        ({"values": (0.0, 1.0)}, "3 of them, as many as breakpoints"),
    ],
)
def test_what_is_no_table_is_refused(changes: dict[str, tuple[float, ...]], text: str) -> None:
    with pytest.raises(ModelError, match=text):
        LookUpTable(**changes)
