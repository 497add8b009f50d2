"""A loop filter whose states are scaled has the same response, and scaling back gives the coefficients again."""

from dataclasses import astuple

import numpy as np
import pytest

from proofmass.runner.design.modulators.structures import FORMS, Coefficients, Structure, loop_response, scaled

SWINGS = (2.0, 0.25, 5.0)
UNSCALED = Coefficients((0.1, 0.2, 0.3), (0.4, 0.5, 0.6, 1.0), (1.0, 2.0, 3.0), (0.01,))


@pytest.mark.parametrize("form", FORMS)
def test_smaller_states_make_the_same_loop(form: str) -> None:
    structure = Structure(form, 3)
    found = scaled(structure, UNSCALED, SWINGS)
    assert loop_response(structure, found, 12) == pytest.approx(loop_response(structure, UNSCALED, 12), rel=1e-12)
    assert np.any(np.asarray(found.c) != np.asarray(UNSCALED.c))
    back = scaled(structure, found, [1.0 / swing for swing in SWINGS])
    for one, other in zip(astuple(back), astuple(UNSCALED), strict=True):
        assert one == pytest.approx(other, rel=1e-14)
