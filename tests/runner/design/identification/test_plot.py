"""The picture of a fit to recordings: curves, residuals and autocorrelation of values that were written by hand."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.design.identification import plot
from proofmass.runner.design.identification.fitted import OutputFit
from proofmass.runner.design.identification.plot import plot_fitted
from proofmass.runner.design.identification.recordings import RecordedStretch
from proofmass.runner.design.identification.whiteness import Whiteness
from proofmass.runner.output.pictures import BLUE, ORANGE
from tests.runner.design.identification.test_text import VOLTS, fitted

TIMES = np.arange(200.0) * 1e-4  # 19.9 ms
MEASURED = 2e-3 * np.cos(np.arange(200.0))
RUN = MEASURED + 2e-6 * np.sin(np.arange(200.0))


def picture(*outputs: OutputFit, signal: str = "seen.output") -> Any:
    """Of two recordings the second is longer; the third has another output."""
    short = RecordedStretch("a", TIMES[:20], {}, {signal: MEASURED[:20]})
    long = RecordedStretch("b", TIMES, {}, {signal: MEASURED})
    other = RecordedStretch("c", np.arange(300.0), {}, {"other": np.ones(300)})
    modelled = ({signal: RUN[:20]}, {signal: RUN}, {"other": np.ones(300)})
    return plot_fitted(fitted(outputs=outputs, recordings=(short, long, other), modelled=modelled))


def test_the_longest_recording_with_its_run_and_what_is_left() -> None:
    upper, closer, lower, panel = picture(VOLTS).axes
    recorded, run = upper.lines
    assert recorded.get_xdata() == pytest.approx(1e3 * TIMES)
    assert recorded.get_ydata() == pytest.approx(1e3 * MEASURED)
    assert run.get_ydata() == pytest.approx(1e3 * RUN)
    assert (recorded.get_color(), run.get_color()) == (ORANGE, BLUE)
    assert upper.get_ylabel() == "seen.output [mV]"
    assert upper.get_title(loc="left") == "seen.output: 98.77 % explained"
    near, fit = closer.lines
    assert near.get_xdata() == pytest.approx(1e3 * TIMES[40:160])
    assert near.get_ydata() == pytest.approx(1e3 * MEASURED[40:160])
    assert fit.get_ydata() == pytest.approx(1e3 * RUN[40:160])
    assert [text.get_text() for text in closer.get_legend().get_texts()] == ["recorded", "fitted"]
    (left,) = lower.lines
    assert left.get_ydata() == pytest.approx(2.0 * np.sin(np.arange(200.0)), rel=1e-6, abs=1e-9)
    assert lower.get_ylabel() == "residual [µV]"
    assert [below.get_xlabel() for below in (closer, lower)] == ["time [ms]"] * 2
    assert upper.get_shared_x_axes().joined(upper, lower)
    (bar,) = panel.patches[1:]
    assert (bar.get_x() + 0.5 * bar.get_width(), bar.get_height()) == pytest.approx((1.0, 0.01))
    band = panel.patches[0]
    assert (band.get_y(), band.get_height()) == pytest.approx((-1.96 / np.sqrt(200.0), 2.0 * 1.96 / np.sqrt(200.0)))
    assert panel.get_title(loc="left") == "autocorrelation: white"
    assert panel.get_xlabel() == "lag [rows]"
    assert panel.lines[0].get_ydata()[0] == 0.0
    places = [one.get_subplotspec() for one in (upper, closer, lower, panel)]
    assert [(p.rowspan.start, p.colspan.start, p.colspan.stop) for p in places] == [
        (0, 0, 2), (0, 2, 3), (1, 0, 2), (1, 2, 3)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("test", "title"),
    [
        (Whiteness(np.array([0.5, 0.25]), 1e-9), "not white"),
        (Whiteness(np.zeros(0), 1.0), "nothing is left"),
    ],
)
def test_what_is_left_is_named(test: Whiteness, title: str) -> None:
    panel = picture(replace(VOLTS, whiteness=test)).axes[3]
    assert panel.get_title(loc="left") == f"autocorrelation: {title}"
    assert len(panel.get_xticks()) == 0 or len(test.autocorrelation) > 0


def test_four_outputs_are_drawn_below_each_other() -> None:
    axes = picture(*[VOLTS] * 5).axes
    assert len(axes) == 16
    assert [panel.get_subplotspec().rowspan.start for panel in axes] == [
        2 * number + row for number in range(4) for row in (0, 0, 1, 1)
    ]


def test_of_a_long_recording_some_rows_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plot, "_ROWS", 50)
    upper, closer, lower, _ = picture(VOLTS).axes
    assert [len(line.get_xdata()) for line in (*upper.lines, *lower.lines)] == [50] * 3
    assert upper.lines[0].get_xdata() == pytest.approx(1e3 * TIMES[::4])
    assert len(closer.lines[0].get_xdata()) == 120


def test_a_short_exact_recording() -> None:
    """It begins at 0, is drawn whole, and nothing is left of it."""
    stretch = RecordedStretch("a", TIMES[:20], {}, {"seen.output": 0.0 * MEASURED[:20]})
    only = fitted(outputs=(VOLTS,), recordings=(stretch,), modelled=({"seen.output": 0.0 * RUN[:20]},))
    upper, closer, lower, _ = plot_fitted(only).axes
    assert len(closer.lines[0].get_xdata()) == 20
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("seen.output [V]", "residual [V]")
