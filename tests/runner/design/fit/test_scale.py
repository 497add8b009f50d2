"""Scaling and back: coefficients that predict the same, intervals that are those of the readings."""

import math

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.design.fit.fit import fit
from proofmass.runner.design.fit.projection import DOUBLE, best
from proofmass.runner.design.fit.scale import ScaledReadings, half_widths
from tests.by_hand.temperature_sets import DEVICES, M1, TEMPERATURE, Device

both = pytest.mark.parametrize("device", DEVICES.values(), ids=DEVICES)


@both
def test_unscaled_coefficients_leave_the_same_residual(device: Device) -> None:
    scaled = ScaledReadings(device.readings())
    assert (scaled.x.min(), scaled.x.max(), np.abs(scaled.v).max()) == pytest.approx((-1.0, 1.0, 1.0), abs=1e-15)
    optimum = best(DOUBLE, scaled.x, scaled.v)
    a, b = scaled.unscaled(optimum)
    left = device.output() - np.exp(np.outer(TEMPERATURE, b)) @ a
    assert left == pytest.approx(optimum.at.residual * scaled.size, abs=1e-15)


@both
def test_intervals_of_the_exponents_do_not_depend_on_the_scale(device: Device) -> None:
    scaled = ScaledReadings(device.readings())
    ours = scaled.intervals(best(DOUBLE, scaled.x, scaled.v))
    coefficients = fit(device.readings(), [], tolerance=1.0).fits[0].coefficients
    expected = [(c.value, c.half_width) for c in coefficients if c.name in ("b1", "b2")]
    for found, wanted in zip(ours, expected, strict=True):
        assert found == pytest.approx(wanted, rel=1e-6)


def test_what_can_be_computed() -> None:
    scaled = ScaledReadings(M1.readings())
    assert scaled.reaches((-100.0, 166.0))
    assert not scaled.reaches((-100.0, 167.0))
    with pytest.raises(ModelError, match=r"exponent -200 at 1\.8"):
        scaled.refuse((-200.0, 1.0), "")


def test_a_column_that_adds_nothing_has_no_interval() -> None:
    columns = np.stack([TEMPERATURE, np.zeros(61)], axis=1)
    assert half_widths(columns, M1.output()) == [math.inf, math.inf]
    assert half_widths(np.stack([TEMPERATURE, 2.0 * TEMPERATURE], axis=1), M1.output()) == [math.inf, math.inf]
