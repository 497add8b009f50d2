"""The better of two fits, for every order of their residuals, and when it is to be believed."""

import itertools

from proofmass.blocks import FitSelector
from tests.by_hand.functions import drive

RESIDUALS = (0.0, 5.2e-3, 5.4e-3, 0.4)


def test_every_combination() -> None:
    cases = list(itertools.product(RESIDUALS, (False, True), RESIDUALS, (False, True)))
    first, second = {"stiffness": 131.0, "damping": 5e-5}, {"stiffness": 145.0, "damping": 8e-5}
    inputs = [
        {
            **{f"first_{name}": value for name, value in {**first, "residual": r1, "settled": s1}.items()},
            **{f"second_{name}": value for name, value in {**second, "residual": r2, "settled": s2}.items()},
        }
        for r1, s1, r2, s2 in cases
    ]
    for (r1, s1, r2, s2), row in zip(cases, drive(FitSelector(), inputs), strict=True):
        better, settled = (second, s2) if r2 < r1 else (first, s1)
        assert (row["stiffness"], row["damping"]) == (better["stiffness"], better["damping"])
        assert row["residual"] == min(r1, r2)
        assert row["converged"] == (settled and min(r1, r2) < 5.4e-3)
