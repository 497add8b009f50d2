"""A signal that would fill its panel is drawn as an envelope, with its last turns beside it."""

import numpy as np
import pytest

from proofmass.runner.output.plot import plot_traces
from tests.by_hand.results import made_result, made_trace


def axes_of(values: np.ndarray) -> list:  # type: ignore[type-arg]
    return list(plot_traces(made_result([made_trace("sine.output", values, "V")])).axes)


@pytest.mark.parametrize("rows_a_turn", [12, 2000])  # many turns in each stretch, and turns of many stretches
def test_an_envelope_and_the_last_turns(rows_a_turn: int) -> None:
    amplitude = 3.0 - np.linspace(0.0, 2.0, 600_000)
    values = amplitude * np.sin(2.0 * np.pi * np.arange(600_000) / rows_a_turn)
    panel, detail = axes_of(values)
    low, high = (line.get_ydata() for line in panel.lines)
    places = np.linspace(0, 599_999, len(high)).astype(int)
    assert np.abs(high - amplitude[places]).max() < 0.05
    assert np.abs(low + amplitude[places]).max() < 0.05
    last = detail.lines[0].get_ydata()
    assert np.array_equal(last, values[-len(last) :])
    turns = np.count_nonzero((last[1:] > 0) != (last[:-1] > 0)) / 2
    assert 4 <= turns <= 8
    assert detail.get_xlabel().startswith("the last ")


def test_a_slow_signal_and_a_short_one_are_lines() -> None:
    assert len(axes_of(np.sin(np.arange(600_000) / 1e5))) == 1
    assert len(axes_of(np.sin(np.arange(300)))) == 1


@pytest.mark.defect("S602", before="stretches joined by slanted lines: an edge looks as wide as one", after="steps")
@pytest.mark.friendly(29, "a band is nowhere off its signal")
def test_an_edge_of_a_band_is_upright_and_nowhere_the_band_misses_the_signal() -> None:
    sine = np.sin(np.arange(600_000) / 3.0)
    values = np.where(np.arange(600_000) < 301_234, sine, 5.0 + sine)
    panel, _ = axes_of(values)
    low, high = panel.lines
    assert low.get_drawstyle() == high.get_drawstyle() == "steps-post"
    to_seconds = made_trace("sine.output", values, "V").times[-1] / (len(values) - 1)
    scale = panel.lines[0].get_xdata()[-1] / (600_000 * to_seconds)  # seconds to the unit of the axis
    starts = np.asarray(low.get_xdata()) / scale / to_seconds
    stretch = np.searchsorted(starts, np.arange(600_000) + 1e-6, side="right") - 1
    assert np.all(np.asarray(low.get_ydata())[stretch] <= values + 1e-12)
    assert np.all(np.asarray(high.get_ydata())[stretch] >= values - 1e-12)
    wide = np.diff(starts).max()
    away = np.abs(np.arange(600_000) - 301_234) > wide
    assert np.all((np.asarray(high.get_ydata())[stretch] < 1.01)[away] == (np.arange(600_000) < 301_234)[away])
