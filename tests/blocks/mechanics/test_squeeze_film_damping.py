"""The damping against the series of the textbook with many terms, and near a wall."""

import math

import numpy as np
import pytest

from proofmass.blocks import SqueezeFilmDamping
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import responses

RATIOS = [0.01, 0.3, 0.7, 1.0]


@pytest.mark.parametrize("ratio", RATIOS)
def test_against_the_series(ratio: float) -> None:
    total = math.fsum(math.tanh(0.5 * math.pi * n / ratio) / n**5 for n in range(1, 2001, 2))
    shape = 1.0 - 192.0 / math.pi**5 * ratio * total
    block = SqueezeFilmDamping(length=2e-3, width=2e-3 * ratio, gap=5e-6, viscosity=20e-6, both_sides=False)
    expected = -shape * 20e-6 * 2e-3 * (2e-3 * ratio / 5e-6) ** 3 * 0.01
    assert responses(block, "force", displacement=[0.0], velocity=[0.01])[0] == pytest.approx(expected, rel=2e-5)


def test_a_square_plate_has_the_factor_of_the_textbook() -> None:
    block = SqueezeFilmDamping(length=1.0, width=1.0, gap=1.0, viscosity=1.0, both_sides=False)
    assert responses(block, "force", displacement=[0.0], velocity=[-1.0])[0] == pytest.approx(0.4217, abs=1e-4)


def test_it_grows_towards_the_wall() -> None:
    one = SqueezeFilmDamping(both_sides=False)
    rest, near, far = responses(one, "force", displacement=[0.0, 2e-6, -4e-6], velocity=[1.0] * 3)
    assert (near / rest, far / rest) == (pytest.approx(8.0, rel=1e-14), pytest.approx(0.125, rel=1e-14))
    both = responses(SqueezeFilmDamping(), "force", displacement=[0.0, 2e-6], velocity=[1.0] * 2)
    assert both == [pytest.approx(2.0 * rest, rel=1e-14), pytest.approx(near + rest / 1.5**3, rel=1e-14)]
    assert math.isnan(responses(SqueezeFilmDamping(), "force", displacement=[-4e-6], velocity=[0.0])[0])


def test_the_shorter_side_is_the_width() -> None:
    with pytest.raises(ModelError, match="at most length"):
        SqueezeFilmDamping(width=2e-3)


@pytest.mark.derivation(
    SqueezeFilmDamping,
    equation="F = -b m L W^3 / h^3 v, b = 1 - 192 / pi^5 W / L sum of tanh(n pi L / (2 W)) / n^5 over odd n",
    source="Reynolds' equation p_xx + p_yy = 12 m v / h^3 by a double sine series over the plate",
    convention="v towards the wall; L and W are whole sides, not halves; both walls at rest twice that of one",
)
@pytest.mark.parametrize("width", [1.0e-3, 0.4e-3])
def test_reynolds_equation_over_the_plate(width: float) -> None:
    length, gap, viscosity, way = 1.0e-3, 3e-6, 18e-6, 1e-6
    m, n = np.meshgrid(np.arange(1, 600, 2), np.arange(1, 600, 2))
    series = 64.0 * length * width / np.pi**6 / (m**2 * n**2 * ((m / length) ** 2 + (n / width) ** 2))
    walls = (gap - way) ** -3 + (gap + way) ** -3
    expected = -12.0 * viscosity * 0.02 * float(series.sum()) * walls
    block = SqueezeFilmDamping(length=length, width=width, gap=gap, viscosity=viscosity)
    found = responses(block, "force", displacement=[way], velocity=[0.02])[0]
    assert found == pytest.approx(expected, rel=2e-5)
