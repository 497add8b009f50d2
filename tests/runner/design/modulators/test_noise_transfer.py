"""Noise transfer functions of low orders in closed form, and what is refused."""

import math
from typing import Any

import numpy as np
import pytest
from scipy import integrate

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.design.modulators.noise_transfer import (
    NoiseTransfer,
    _half,
    _poles,
    _sorted,
    _spread,
    band,
    synthesised,
)
from proofmass.runner.design.modulators.prediction import _in_band, _one_bit, _powers, predicted

FIRST, SECOND = NoiseTransfer((1.0,), (0.0,)), NoiseTransfer((1.0, 1.0), (0.0, 0.0))


def test_gains_of_first_and_second_differences() -> None:
    """(z - 1) / z at half the rate is 2, and at a quarter 1 + j."""
    assert FIRST.at(0.5) == pytest.approx(2.0)
    assert FIRST.at(0.25) == pytest.approx(1.0 + 1.0j)
    assert SECOND.at([0.25, 0.5]) == pytest.approx(np.array([2.0j, 4.0]))


def test_the_loop_filter_that_a_transfer_needs() -> None:
    """1 - 1 / H: a sum, a sum of sums, and of (z - 1) / (z - 1/2) half of a sum."""
    assert FIRST.loop_response(3).tolist() == [-1.0, -1.0, -1.0]
    assert SECOND.loop_response(4).tolist() == [-2.0, -3.0, -4.0, -5.0]
    assert NoiseTransfer((1.0,), (0.5,)).loop_response(2).tolist() == [-0.5, -0.5]
    assert NoiseTransfer((0.0, 0.0), (0.5, 0.25)).loop_response(3).tolist() == [0.75, -0.125, 0.0]


def test_bands() -> None:
    assert band(32.0, 0.0) == (0.0, 1.0 / 64.0)
    assert band(32.0, 0.25) == (0.25 - 1.0 / 128.0, 0.25 + 1.0 / 128.0)
    assert _half(32.0, 0.0) == pytest.approx(math.pi / 32.0)
    assert _half(32.0, 0.25) == pytest.approx(math.pi / 64.0)


@pytest.mark.parametrize(
    ("count", "zeros", "spread"),
    [
        (1, "optimised", [0.0]),
        (2, "optimised", [-math.sqrt(1.0 / 3.0), math.sqrt(1.0 / 3.0)]),
        (3, "optimised", [-math.sqrt(0.6), 0.0, math.sqrt(0.6)]),
        (4, "optimised", [-0.8611363116, -0.3399810436, 0.3399810436, 0.8611363116]),
        (4, "centred", [-math.sqrt(5.0 / 7.0), 0.0, 0.0, math.sqrt(5.0 / 7.0)]),
        (3, "centred", [-math.sqrt(0.6), 0.0, math.sqrt(0.6)]),
        (2, "centred", [0.0, 0.0]),
        (1, "centred", [0.0]),
        (4, "none", [0.0] * 4),
    ],
)
def test_zeros_of_least_power_are_legendres(count: int, zeros: str, spread: list[float]) -> None:
    """With two at the centre x^2 (x^2 - a) has the least power for a = 5 / 7."""
    assert _spread(count, zeros) == pytest.approx(spread, abs=1e-9)


def test_poles_of_first_order() -> None:
    """z + 1 / z = 2 + X: of X = 1 / 2 the pole is 1 / 2. About a quarter of the rate: z + 1 / z = -j X^(1/2)."""
    assert _poles(1, 0.0, math.log(0.5)) == pytest.approx(np.array([0.5]))
    found = _poles(2, 0.25, 2.0 * math.log(1.5))
    assert sorted(found.imag) == pytest.approx([-0.5, 0.5])
    assert found.real == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("oversampling", [8.0, 64.0])
def test_transfers_of_least_order(oversampling: float) -> None:
    """2 / (1 + p) = 1.6 of the pole p = 1 / 4, and about a quarter of the rate the same of z^2."""
    first = synthesised(1, oversampling, 1.6)
    assert first.zeros == (1.0,)
    assert first.poles == (pytest.approx(0.25, abs=1e-13),)
    assert synthesised(1, oversampling).poles == (pytest.approx(1.0 / 3.0),), "of the usual gain 1.5"
    second = synthesised(2, oversampling, 1.6, centre=0.25)
    assert second.zeros == (pytest.approx(-1j), pytest.approx(1j))
    assert second.poles == (pytest.approx(-0.5j), pytest.approx(0.5j))


def test_zeros_of_third_order_lie_in_the_band() -> None:
    angles = [np.angle(zero) for zero in synthesised(3, 10.0).zeros]
    w = math.sqrt(0.6) * math.pi / 10.0
    assert angles == pytest.approx([0.0, -w, w])
    above = [np.angle(zero) for zero in synthesised(4, 10.0, centre=0.4).zeros]
    apart = math.sqrt(1.0 / 3.0) * math.pi / 20.0
    assert above == pytest.approx([sign * (0.8 * math.pi + side * apart) for side in (-1, 1) for sign in (-1, 1)])


@pytest.mark.parametrize("centre", [0.2, 0.25, 0.3])
def test_the_gain_is_that_at_the_end_further_from_the_band(centre: float) -> None:
    transfer = synthesised(2, 32.0, 1.3, centre=centre)
    assert abs(complex(transfer.at(0.5 if centre < 0.25 else 0.0))) == pytest.approx(1.3)


def test_roots_stand_in_pairs_without_rounding() -> None:
    roots = np.array([1j, 0.5 + 2e-10j, -1.0, -1j, 0.25 - 2e-9j])
    assert _sorted(roots) == (0.5 + 0j, 0.25 - 2e-9j, -1j, 1j, -1.0 + 0j)


@pytest.mark.parametrize(
    ("given", "key", "expected"),
    [
        ({"order": 0}, "order", "1 to 8"),
        ({"order": 9}, "order", "1 to 8"),
        ({"oversampling": 1.99}, "oversampling", "at least 2"),
        ({"oversampling": math.inf}, "oversampling", "at least 2"),
        ({"oversampling": math.nan}, "oversampling", "at least 2"),
        ({"zeros": "optimized"}, "zeros", "optimised, centred, none"),
        ({"order": 3, "centre": 0.25}, "centre", "an even order"),
        ({"order": 2, "centre": 0.25 / 32.0}, "centre", "a band between 0 and half the rate"),
        ({"order": 2, "centre": 0.5 - 0.25 / 32.0}, "centre", "a band between 0 and half the rate"),
        ({"gain": 1.0}, "gain", "above 1, below 2"),
        ({"gain": 2.0}, "gain", "above 1, below 2"),
        ({"gain": -1.0}, "gain", "above 1, below 2"),
        ({"gain": 0.0}, "gain", "above 1, below 2"),
        ({"gain": math.nan}, "gain", "above 1, below 2"),
        ({"gain": math.inf}, "gain", "above 1, below 2"),
        ({"order": 2, "gain": 4.0, "zeros": "none"}, "gain", "above 1, below 4"),
    ],
)
def test_what_has_no_transfer_function(given: dict[str, Any], key: str, expected: str) -> None:
    with pytest.raises(ModelError) as refused:
        synthesised(**{"order": 1, "oversampling": 32.0, **given})
    (problem,) = refused.value.problems
    assert (problem.key, problem.expected) == (key, expected)


@pytest.mark.parametrize(
    "given",
    [{"order": 8}, {"order": 1, "oversampling": 2.0}, {"order": 2, "centre": 0.008}, {"order": 2, "centre": 0.492}],
)
def test_bounds_are_allowed(given: dict[str, Any]) -> None:
    assert synthesised(**{"oversampling": 32.0, "gain": 1.3, **given}).poles


def in_band(gain: float, low: float, high: float) -> float:
    """Of (z - 1) / (z - 1 + k): its power between two frequencies and their negative ones."""

    def density(f: float) -> float:
        z = np.exp(2j * math.pi * f)
        return float(abs((z - 1.0) / (z - 1.0 + gain)) ** 2)

    return 2.0 * float(integrate.quad(density, low, high)[0])


def test_the_part_of_the_noise_in_a_band() -> None:
    """Of a difference that is 4 B - 2 sin(2 pi B) / pi below B."""
    assert _in_band(FIRST, 1.0, (0.0, 0.125)) == pytest.approx(0.5 - math.sqrt(2.0) / math.pi)
    assert _in_band(FIRST, 0.5, (0.1, 0.25)) == pytest.approx(in_band(0.5, 0.1, 0.25))


def test_ratios_of_several_levels_have_the_noise_of_a_step() -> None:
    """Three levels have steps of 1, so 1 / 12; five have steps of 1 / 2."""
    for levels, step in ((3, 1.0), (5, 0.5)):
        ratios, limit = predicted(FIRST, (0.0, 0.125), (0.5, 1.0), levels)
        noise = step**2 / 12.0 * (0.5 - math.sqrt(2.0) / math.pi)
        assert ratios == pytest.approx([10.0 * math.log10(0.125 / noise), 10.0 * math.log10(0.5 / noise)])
        assert limit == 1.0


def test_ratios_of_one_bit_up_to_overload() -> None:
    """The gain follows from 2 / (2 - k) = 1 + m^2 / s; the least growth of the gains is that of 0.02."""
    (low, high, over), limit = predicted(FIRST, (0.0, 0.05), (0.25, 0.75, 1.26), 2)
    for amplitude, ratio in ((0.25, low), (0.75, high)):
        passed, added = _powers(amplitude)
        gain = 2.0 - 2.0 / (1.0 + passed / added)
        noise = added * in_band(gain, 0.0, 0.05)
        assert ratio == pytest.approx(10.0 * math.log10(0.5 * amplitude**2 / noise))
    assert (over, limit) == (None, 1.0)
    assert _one_bit(FIRST, (0.0, 0.05), 0.75, 1.99) is None, "all gains above 1.99 let the noise grow more"
