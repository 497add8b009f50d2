"""The Bessel filter against scipy.signal, sample by sample, and its table against the polynomial."""

import mpmath
import pytest
from scipy import signal

from proofmass.blocks import Bessel
from proofmass.blocks.arithmetic.prototypes import TABLE
from tests.by_hand.responses import distance, noise, response

INPUT = noise(500)


@pytest.mark.parametrize("high", [False, True])
@pytest.mark.parametrize("order", range(1, 9))
@pytest.mark.parametrize("corner", [10.0, 120.0, 450.0])
def test_against_scipy(order: int, corner: float, high: bool) -> None:
    block = Bessel(order=order, corner_frequency=corner, high_pass=high)
    sections = signal.bessel(order, corner, "high" if high else "low", norm="mag", fs=1000.0, output="sos")
    assert distance(response(block, INPUT, period=1e-3), signal.sosfilt(sections, INPUT)) < 1e-12


@pytest.mark.parametrize("order", range(1, 9))
def test_the_table_holds_the_roots_of_the_reverse_bessel_polynomial(order: int) -> None:
    """sum of (2n - k)! / (2^(n-k) k! (n - k)!) s^k, up to the scale that the corner fixes."""
    fac = mpmath.factorial
    powers = [fac(2 * order - k) / (2 ** (order - k) * fac(k) * fac(order - k)) for k in range(order + 1)]
    with mpmath.workdps(30):
        roots = mpmath.polyroots(powers, maxsteps=500, extraprec=300, asc=True)
        upper = sorted((r for r in roots if r.imag > -1e-20), key=lambda r: -abs(r.imag))
        scale = abs(upper[0]) / TABLE[8 * (order - 1)]
        for i, root in enumerate(upper):
            w, q = TABLE[8 * (order - 1) + 2 * i : 8 * (order - 1) + 2 * i + 2]
            assert abs(root) / scale == pytest.approx(w, rel=1e-14)
            if abs(root.imag) > 1e-15:
                assert -0.5 * abs(root) / root.real == pytest.approx(q, rel=1e-14)
        value = sum(power * mpmath.mpc(0, scale) ** k for k, power in enumerate(powers))
        assert abs(value / powers[0]) ** 2 == pytest.approx(2.0, rel=1e-13)
