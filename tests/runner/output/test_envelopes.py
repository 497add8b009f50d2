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
