"""The picture of Allan deviations: its interval and curves are those of the answer, in units of the field."""

import math

import numpy as np
import pytest

from proofmass import allan
from proofmass.runner.analysis.allan.plot import plot_allan


def test_interval_and_curves_are_those_of_the_answer() -> None:
    """Degrees a second are drawn as degrees an hour."""
    answer = allan(np.random.default_rng(1).normal(size=400), rate=100.0, unit="deg/s")
    curve = answer.curves["allan"]  # type: ignore[index]
    (panel,) = plot_allan(answer).axes
    (band,) = panel.collections
    edge = {tuple(row) for row in np.round(np.log10(band.get_paths()[0].vertices), 9).tolist()}
    for side in (curve.low, curve.high):
        assert edge >= {
            (round(math.log10(tau), 9), round(math.log10(3600.0 * value), 9))
            for tau, value in zip(curve.taus, side, strict=True)
        }
    measured, model = panel.lines[:2]
    assert np.asarray(measured.get_ydata()) == pytest.approx(3600.0 * curve.deviation)
    assert np.asarray(model.get_ydata()) == pytest.approx(3600.0 * np.sqrt(answer.levels.variance(curve.taus)))
    assert panel.get_ylabel() == "deviation [°/h]"
