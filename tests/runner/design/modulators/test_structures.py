"""A loop filter whose states are scaled has the same response, and scaling back gives the coefficients again."""

from dataclasses import astuple

import numpy as np
import pytest

from proofmass import design_modulator
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


@pytest.mark.defect(
    "S914",
    before="an input into the first state alone came out 13 times as large, or 22 times as small",
    after="with a gain of 1 at the centre of the band",
)
@pytest.mark.parametrize(
    ("order", "oversampling", "centre", "form", "pulse"),
    [
        (2, 64.0, 0.1, "CRFB", None),
        (4, 64.0, 0.48, "CRFB", None),
        (4, 64.0, 0.4, "CRFB", (0.0, 1.0)),
        (6, 8.0, 0.0, "CRFB", None),
        (4, 8.0, 0.0, "CIFB", None),
        (4, 32.0, 0.25, "CRFB", None),
    ],
)
def test_an_input_has_its_size_in_the_band(
    order: int, oversampling: float, centre: float, form: str, pulse: tuple[float, float] | None
) -> None:
    """By recursion: a loop whose quantiser passes what it sees settles on a sine of the same size."""
    of = design_modulator(order, oversampling, centre=centre, form=form, pulse=pulse, samples=1024)
    rows, last = of.structure.stepped(of.coefficients)
    turns, x, seen = np.exp(2j * np.pi * centre * np.arange(3000)), np.zeros(order, complex), 0j
    for u in turns:
        seen = last[:order] @ x + last[order] * u
        x = rows @ [*x, u, seen]
    assert abs(seen) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.defect("S915", before="a gain of 1.5 far from the band, which is 1.72", after="1.72")
def test_the_gain_is_that_of_the_zeros_of_the_form() -> None:
    """CIFF has its zeros at 1 +- j sqrt(g). Its loop at half the rate: 1 / (1 - L), L by its matrices."""
    of = design_modulator(8, 8.0, form="CIFF", samples=1024)
    rows, last = of.structure.stepped(of.coefficients)
    loop = last[:8] @ np.linalg.solve(-np.eye(8) - rows[:, :8], rows[:, 9])
    assert of.gain == pytest.approx(abs(1.0 / (1.0 - loop)), rel=1e-6)
    assert of.gain > 1.7
