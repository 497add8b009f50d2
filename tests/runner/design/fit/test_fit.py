"""Fits against SciPy's least squares and NumPy's polynomials, their intervals against repeated experiments."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from scipy.optimize import curve_fit, least_squares

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.design.fit.data import Readings
from proofmass.runner.design.fit.fit import Fit, _sizes, fit
from tests.by_hand.temperature_sets import DEVICES, M1, TEMPERATURE, Device, fitted

both = pytest.mark.parametrize("device", DEVICES.values(), ids=DEVICES)


def law(temperature: Any, a1: float, b1: float, a2: float, b2: float) -> Any:
    return a1 * np.exp(b1 * temperature) + a2 * np.exp(b2 * temperature)


def readings(temperature: Any, output: Any) -> Readings:
    return Readings("made", np.asarray(temperature), np.asarray(output), "temperature", "output")


def rmse_of(fitted: Fit) -> float:
    return math.sqrt(float(np.mean(fitted.residual**2)))


@pytest.mark.exhaustive("m2")
@both
def test_two_exponentials_against_least_squares_from_many_starts(device: Device) -> None:
    output, size = device.output(), device.before
    found = [
        least_squares(
            lambda p: (law(TEMPERATURE, p[0] * size, p[1], p[2] * size, p[3]) - output) / size,
            [1.0, b1, 1.0, b2],
            bounds=([-np.inf, -20.0] * 2, [np.inf, 20.0] * 2),
            x_scale="jac",
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
            max_nfev=2000,
        )
        for b1, b2 in [(-6.0, 1.5), (-1.0, 1.0), (-3.0, 2.0), (-8.0, 0.5)]
    ]
    lowest = min(found, key=lambda result: result.cost)
    ours = fitted(device).fits[0]
    assert ours.rmse == pytest.approx(size * math.sqrt(2.0 * lowest.cost / 61), rel=1e-9)
    expected = lowest.x * [size, 1.0, size, 1.0]
    assert list(ours.values.values()) == pytest.approx(expected.tolist(), rel=1e-4)


@both
def test_intervals_against_curve_fit(device: Device) -> None:
    ours = fitted(device).fits[0]
    start = list(ours.values.values())
    _, covariance = curve_fit(law, TEMPERATURE, device.output(), p0=start)
    assert [c.half_width for c in ours.coefficients] == pytest.approx(
        (2.0024654592910065 * np.sqrt(np.diag(covariance))).tolist(), rel=1e-3
    )  # Student's t of 57 degrees of freedom, from a table


@pytest.mark.exhaustive
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    dice, truth = np.random.default_rng(5), M1.law()
    clean = law(TEMPERATURE, **truth)
    inside = []
    for _ in range(40):
        noisy = readings(TEMPERATURE, clean + 2e-5 * dice.standard_normal(61))
        for c in fit(noisy, tolerance=1.0).fits[0].coefficients:
            inside.append(abs(c.value - truth[c.name]) <= c.half_width)
    assert 0.88 < np.mean(inside) < 0.99


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5, 6])
def test_polynomials_against_numpy(order: int) -> None:
    ours = fit(M1.readings(), [order], tolerance=1.0).fits[2]
    expected = Polynomial.fit(TEMPERATURE, M1.output(), order)
    assert list(ours.values.values()) == pytest.approx(expected.convert().coef.tolist(), rel=1e-8)
    assert ours.rmse == pytest.approx(np.sqrt(np.mean((M1.output() - expected(TEMPERATURE)) ** 2)), rel=1e-10)


def test_intervals_of_a_straight_line_by_hand() -> None:
    slope = fit(M1.readings(), [1], tolerance=1.0).fits[2].coefficients[1]
    line = np.polyfit(TEMPERATURE, M1.output(), 1)
    left = M1.output() - np.polyval(line, TEMPERATURE)
    spread = math.sqrt(float(left @ left) / 59 / float(((TEMPERATURE - 1.2) ** 2).sum()))
    assert slope.half_width == pytest.approx(2.0009953780882688 * spread, rel=1e-9)


@both
def test_measures_are_those_of_the_coefficients(device: Device) -> None:
    report = fitted(device)
    output = device.output()
    assert report.before == np.ptp(output)
    for model in report.fits:
        predicted = (
            law(TEMPERATURE, **model.values)
            if "a1" in model.values
            else Polynomial(list(model.values.values()))(TEMPERATURE)
        )
        assert model.residual == pytest.approx(output - predicted, abs=1e-12)
        assert model.after == pytest.approx(np.ptp(output - predicted), rel=1e-8)
        assert model.rmse == pytest.approx(rmse_of(model), rel=1e-12)
        assert model.r_squared == pytest.approx(1.0 - model.rmse**2 / output.var(), rel=1e-12)


@pytest.mark.exhaustive
@given(st.floats(-5.0, -1.0), st.floats(0.5, 4.0), st.floats(0.2, 5.0), st.floats(0.2, 5.0), st.booleans())
@settings(max_examples=15)
def test_an_exact_law_is_found(falling: float, rising: float, first: float, second: float, minus: bool) -> None:
    x = np.linspace(-1.0, 1.0, 41)
    a1, a2 = first, -second if minus else second
    found = fit(readings(x, law(x, a1, falling, a2, rising)), tolerance=1.0)
    assert list(found.fits[0].values.values()) == pytest.approx([a1, falling, a2, rising], rel=1e-6)
    assert found.fits[0].converged


@pytest.mark.exhaustive
@given(st.floats(-3.0, 3.0), st.floats(0.2, 100.0), st.floats(0.001, 1000.0))
@settings(max_examples=8)
def test_scaling_and_shifting(shift: float, stretch: float, gain: float) -> None:
    reference = fit(M1.readings(), [], tolerance=1.0).fits[0]
    moved = fit(readings(stretch * TEMPERATURE + shift, gain * M1.output()), [], tolerance=1.0).fits[0]
    assert moved.rmse == pytest.approx(gain * reference.rmse, rel=1e-9)
    for one in ("1", "2"):
        b = reference.values[f"b{one}"] / stretch
        assert moved.values[f"b{one}"] == pytest.approx(b, rel=1e-4)
        expected = gain * reference.values[f"a{one}"] * math.exp(-b * shift)
        assert moved.values[f"a{one}"] == pytest.approx(expected, rel=1e-3)


def test_the_order_of_the_rows_does_not_matter() -> None:
    shuffled = np.random.default_rng(1).permutation(61)
    turned = readings(TEMPERATURE[shuffled], M1.output()[shuffled])
    assert fit(turned).fits[0].rmse == pytest.approx(fitted(M1).fits[0].rmse, rel=1e-12)


def test_units_of_the_coefficients() -> None:
    report = fit(dataclasses.replace(M1.readings(), temperature_unit="K", output_unit="m/s^2"))
    units = {c.name: c.unit for model in report.fits for c in model.coefficients}
    assert units["a1"] == units["c0"] == "m/s^2"
    assert units["b2"] == "1/K"
    assert units["c2"] == "(m/s^2)/K^2"
    assert {c.unit for f in fit(readings(TEMPERATURE, M1.output())).fits for c in f.coefficients} == {""}


def test_no_order_beyond_the_temperatures() -> None:
    few = readings([0.6, 0.8, 1.0, 1.2, 1.8], [5.0, 3.0, 2.0, 1.9, 4.0])
    report = fit(few, [3, 4, 5, 6])
    assert [f.model for f in report.fits[2:]] == ["polynomial of order 3", "polynomial of order 4"]
    assert report.fits[3].rmse < 1e-12
    assert all(math.isinf(c.half_width) for c in report.fits[3].coefficients)


def test_exponentials_that_no_block_could_compute_are_refused() -> None:
    with pytest.raises(ModelError, match="too far from zero"):
        fit(readings(TEMPERATURE + 1000.0, M1.output()))
    with pytest.raises(ModelError, match="does not depend on the temperature"):
        fit(readings(TEMPERATURE + 1000.0, np.cos(37.0 * TEMPERATURE)))
    with pytest.raises(ModelError, match="start nearer to zero"):
        fit(M1.readings(), start=(-1e6, 1.0))


def test_what_a_residual_says_of_a_model() -> None:
    """Of 1, 2 to 6 a residual of 0.1 leaves 0.06 of the squares 17.5 about the mean."""
    readings = Readings("six", np.arange(6.0), np.arange(1.0, 7.0), "T", "V")
    sizes = _sizes(readings, np.array([0.1, -0.1, 0.1, -0.1, 0.1, -0.1]))
    found = Fit("line", "least squares", (), *sizes)
    assert (found.r_squared, found.rmse, found.after) == pytest.approx((1.0 - 0.06 / 17.5, 0.1, 0.2))
    assert (found.iterations, found.converged) == (1, True)
