"""Pictures of lifetimes by hand, and names in lines."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.studies.ages import YEAR
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.draws.factors import Factors
from proofmass.runner.studies.outcome.lifetimes import Lifetimes
from proofmass.runner.studies.shown.influences import Influences
from proofmass.runner.studies.shown.plot import _in_lines, plot_curves, plot_influences, plot_lifetimes, plot_shares
from proofmass.runner.studies.shown.sensitivities import Influence, Regression


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


def test_the_law_of_lifetimes_is_drawn_up_to_the_last_age() -> None:
    """In years, whatever its own unit: e^-t of t years."""
    ages, none, law = (0.0, YEAR, 2.0 * YEAR), np.zeros(3), SimpleNamespace(survival=lambda t: np.exp(-t / YEAR))
    pairs = ((0.0, 0.0),) * 3
    lives = Lifetimes(
        "bias", 9, (0, 1, 2), ages, none, pairs, none, pairs, np.zeros(9, dtype=bool), 0.2, law, 0.1, (0.0, 1.0)
    )  # type: ignore[arg-type]
    curve = plot_lifetimes(lives).axes[1].lines[-1]
    assert curve.get_label() == "Weibull's law"
    assert (curve.get_xdata()[0], curve.get_xdata()[-1]) == (0.0, 2.0)
    assert curve.get_ydata() == pytest.approx(100.0 * np.exp(-curve.get_xdata()))


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


BIAS = PlannedMeasure("bias", "adc.code", "mean", "V", ("adc", "code"), reduced=False, first=0)


def influence(effect: float, *parameters: str, share: float = 0.1) -> Influence:
    return Influence(parameters, 1.0, effect, 0.125, effect, effect, share)


def influences(*of: Influence, runs: int = 600) -> Influences:
    """The second factor is small, and has no unit."""
    spread = np.linspace(-1.0, 1.0, runs)
    columns = {i.parameters[0]: spread * 4e-6 * 10.0**k for k, i in enumerate(of)}
    units = {name: "kg" if k == 0 else "1" for k, name in enumerate(columns)}
    regression = Regression(of, 0.9, 0.8, runs)
    return Influences(BIAS, 0, np.zeros(runs, dtype=int), Factors(columns, units), 2.0 * spread, regression)


def test_bars_of_influences_and_the_two_strongest_as_points() -> None:
    """4 ug and 40 ppm are written with small numbers; 500 points of 600 runs are drawn."""
    named = influence(1.5, "sensor.mass", "sensor.damping"), influence(-0.5, "gain.gain"), influence(0.25, "adc.offset")
    tornado, first, second = plot_influences(influences(*named)).axes
    bars = [bar for bar in tornado.patches if bar.get_height() == 0.7]
    assert [(bar.get_x() + min(bar.get_width(), 0.0), abs(bar.get_width())) for bar in bars] == [
        (0.0, 1.5),
        (-0.5, 0.5),
        (0.0, 0.25),
    ]
    colours = [bar.get_facecolor() for bar in bars]
    assert colours[0] == colours[2] != colours[1]
    names = [label.get_text() for label in tornado.get_yticklabels()]
    assert names == ["sensor.mass and 1 more", "gain.gain", "adc.offset"]
    assert tornado.get_xlabel() == "bias [V] for one standard deviation"
    (ends,) = [line.get_segments() for line in tornado.collections]
    assert [[point[0] for point in ends_of_one] for ends_of_one in ends] == [
        [1.375, 1.625],
        [-0.625, -0.375],
        [0.125, 0.375],
    ]
    for panel, unit, largest in ((first, "sensor.mass [mg]", 4.0), (second, "gain.gain [ppm]", 40.0)):
        x, y = panel.lines[0].get_xdata(), panel.lines[0].get_ydata()
        assert panel.get_xlabel() == unit
        assert (len(x), x[0], x[-1]) == pytest.approx((500, -largest, largest * (2.0 * 499.0 / 599.0 - 1.0)))
        assert y == pytest.approx(np.linspace(-2.0, 2.0, 600)[:500])
    assert first.get_ylabel() == "bias [V]"
    assert [panel.get_subplotspec().colspan.start for panel in (tornado, first, second)] == [0, 1, 2]
    assert tornado.get_gridspec().nrows == 1
    assert list(tornado.lines[-1].get_xdata()) == [0.0, 0.0]
    assert [panel.yaxis.get_tick_params()["labelleft"] for panel in (first, second)] == [True, False]
    widths = [panel.get_gridspec().get_width_ratios() for panel in (tornado, first, second)]
    assert widths == [[1.6, 1.0, 1.0]] * 3
    assert first.get_shared_y_axes().joined(first, second)
    assert not first.get_shared_y_axes().joined(first, tornado)


def test_influences_that_are_many_or_one() -> None:
    """Twelve bars at most; a single factor has one panel of points."""
    many = [influence(15.0 - k, f"p{k}") for k in range(14)]
    names = [label.get_text() for label in plot_influences(influences(*many)).axes[0].get_yticklabels()]
    assert names == [f"p{k}" for k in range(12)]
    assert len(plot_influences(influences(many[0])).axes) == 2


def test_shares_over_the_age() -> None:
    """In percent, the factor first that has most at all ages together; five of them, and what all explain."""
    young = [influence(1.0, f"p{k}", share=0.01 * k) for k in range(1, 7)]
    old = [influence(1.0, "p1", share=0.5), influence(1.0, "p6", share=0.05)]
    regressions = [Regression(tuple(young), 0.21, 0.0, 10), Regression(tuple(old), 0.55, 0.0, 10)]
    (panel,) = plot_shares([0.0, 2.0 * YEAR], regressions).axes
    drawn = {line.get_label(): line.get_ydata() for line in panel.lines}
    assert {name: list(map(round, values)) for name, values in drawn.items()} == {
        "p1": [1, 50], "p6": [6, 5], "p5": [5, 0], "p4": [4, 0], "p3": [3, 0], "all factors": [21, 55],
    }  # fmt: skip
    assert list(drawn) == ["p1", "p6", "p5", "p4", "p3", "all factors"]
    assert all(line.get_xdata().tolist() == [0.0, 2.0] for line in panel.lines)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("age [years]", "share of variance [%]")
    (hours,) = plot_shares([0.0, 7200.0], regressions).axes
    assert (hours.get_xlabel(), hours.lines[0].get_xdata().tolist()) == ("age [hours]", [0.0, 2.0])


@pytest.mark.parametrize("number", [1, 2, 3])
def test_curves_over_a_parameter(number: int) -> None:
    """Means; of two curves or less the percentiles 1 and 99 of 0, 1 ... 100 too. A curve without values is left out."""
    column = np.arange(101.0)
    nothing = np.zeros(0), np.nan
    curves = {
        f"c{k}": [(1.0, column + k, 50.0 + k), (2.0, column + 2 * k, 50.0 + 2 * k), (3.0, *nothing)]
        for k in range(number)
    }
    (panel,) = plot_curves({**curves, "none": [(1.0, *nothing)]}, "gain", BIAS).axes
    for k, line in enumerate(panel.lines):
        assert line.get_xydata().tolist() == [[1.0, 50.0 + k], [2.0, 50.0 + 2 * k]]
        assert line.get_label() == f"c{k}"
    assert len(panel.lines) == number
    assert len(panel.collections) == (number if number < 3 else 0)
    if number < 3:
        corners = panel.collections[-1].get_paths()[0].vertices
        assert (corners[:, 1].min(), corners[:, 1].max()) == pytest.approx((1.0 + number - 1, 99.0 + 2 * (number - 1)))
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("gain", "bias [V]")
