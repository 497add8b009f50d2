"""Pictures of lifetimes by hand, and names in lines."""

from typing import Any

import numpy as np
import pytest

from proofmass.graphs.studies.ages import YEAR
from proofmass.runner.studies.outcome.lifetimes import Lifetimes
from proofmass.runner.studies.shown.plot import _in_lines, plot_lifetimes


def edges(panel: Any) -> list[tuple[float, float]]:
    """The lower and the upper edge of a band at each of three ages."""
    (band,) = panel.collections
    corners = band.get_paths()[0].vertices
    heights = [corners[np.isclose(corners[:, 0], at), 1] for at in (0.0, 1.0, 3.0)]
    return [(round(float(column.min()), 9), round(float(column.max()), 9)) for column in heights]


def test_lifetimes_are_drawn_in_percent_over_years() -> None:
    lives = Lifetimes(
        limit="bias",
        sensors=40,
        epochs=(0, 1, 2),
        ages=(0.0, YEAR, 3.0 * YEAR),
        good=np.array([1.0, 0.9, 0.7]),
        good_intervals=((0.91, 1.0), (0.76, 0.97), (0.53, 0.83)),
        surviving=np.array([1.0, 0.85, 0.1]),
        surviving_intervals=((0.91, 1.0), (0.7, 0.94), (0.03, 0.24)),
        good_at_last=np.arange(40) < 28,
        band=0.2,
        law=None,
        time_out=0.1,
        time_out_interval=(0.05, 0.15),
    )
    good, survival = plot_lifetimes(lives).axes
    assert good.lines[0].get_xydata().tolist() == [[0.0, 100.0], [1.0, 90.0], [3.0, 70.0]]
    assert edges(good) == [(91.0, 100.0), (76.0, 97.0), (53.0, 83.0)]
    assert survival.lines[0].get_xydata().tolist() == [[0.0, 100.0], [1.0, 85.0], [3.0, 10.0]]
    assert edges(survival) == [(80.0, 100.0), (65.0, 100.0), (0.0, 30.0)]
    assert (good.get_xlabel(), good.get_ylabel()) == ("age [years]", "within bias [%]")


@pytest.mark.parametrize(
    ("name", "lines"),
    [
        ("seed", "seed"),
        ("sensor.stiffness", "sensor.stiffness"),  # 16 letters stand in one line
        ("readout.stiffness", "readout.\nstiffness"),
        ("change of adc.gain", "change of\nadc.gain"),
        ("change of accelerometer.sensor.mass", "change of\naccelerometer.sensor.\nmass"),
    ],
)
def test_long_names_stand_in_lines(name: str, lines: str) -> None:
    assert _in_lines(name) == lines
