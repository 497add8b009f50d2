"""Crossovers and peaks of sampled loops by a grid about their poles: against a grid of thirty thousand points."""

import flint

from proofmass.runner.analysis.linearisation.rational import Transfer
from proofmass.runner.analysis.margins.swept import SweptAxis
from tests.by_hand.axis_by_grid import ByGrid, random_loops
from tests.by_hand.axis_questions import compared


def axis_of(above: list[int], below: list[int]) -> SweptAxis:
    return SweptAxis(
        Transfer(flint.fmpz_poly(above), flint.fmpz_poly(below)), list(ByGrid(above, below, True).closed_poles())
    )


def test_random_loops() -> None:
    for loop in random_loops(True, 40):
        compared(axis_of(loop.above, loop.below), loop, rel=1e-7)
