"""Sections of second order: identity beyond the order, and the state of scipy's cascade."""

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks.arithmetic.prototypes import Prototype
from proofmass.blocks.arithmetic.sections import Delays, Sections, designed, output, settled, update, warped

POLES = Prototype(3.0, 1.0, 0.7, 0.0, 1.1, 0.9, 0.0, 1.2, 1.5, 0.0, 1.3, 3.0, 0.0)


def rows(c: Sections) -> np.ndarray:
    """As scipy has them."""
    return np.array([[*c[5 * i : 5 * i + 3], 1.0, *c[5 * i + 3 : 5 * i + 5]] for i in range(4)])


@pytest.mark.parametrize("order", range(1, 9))
@pytest.mark.parametrize("high", [False, True])
def test_any_sections_against_sosfilt(order: int, high: bool) -> None:
    c = designed(POLES, order, high, 0.4)
    x, outputs = Delays(*[0.0] * 8), []
    u = np.random.default_rng(1).normal(size=300).tolist()
    for value in u:
        outputs.append(output(c, x, value))
        x = update(c, x, value)
    assert outputs == pytest.approx(signal.sosfilt(rows(c), u), abs=1e-12)


@pytest.mark.parametrize("high", [False, True])
def test_gain_where_it_passes(high: bool) -> None:
    for order in range(1, 9):
        _, h = signal.sosfreqz(rows(designed(POLES, order, high, 0.4)), [0.0, np.pi])
        assert abs(h[1] if high else h[0]) == pytest.approx(3.0, rel=1e-12)
        assert abs(h[0] if high else h[1]) < 1e-12


@pytest.mark.parametrize("order", range(1, 9))
@pytest.mark.parametrize("high", [False, True])
def test_what_has_settled_stays(order: int, high: bool) -> None:
    c = designed(POLES, order, high, 0.4)
    x = settled(c, 2.5)
    assert output(c, x, 2.5) == pytest.approx(0.0 if high else 7.5, abs=1e-12)
    assert update(c, x, 2.5) == pytest.approx(x, abs=1e-12)


def test_the_corner_is_warped_and_at_most_half_the_rate() -> None:
    assert warped(0.25, 1.0) == pytest.approx(1.0, rel=1e-15)
    assert warped(0.6, 1.0) == warped(0.5, 1.0) > 1e6
