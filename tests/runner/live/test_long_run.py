"""Runs that the process does for a page: rows as envelopes, and measures as a plain run has them."""

import threading
from typing import Any

import numpy as np
import pytest

from proofmass import Graph
from proofmass.blocks import Gain, Ramp
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.live import long_run as module
from proofmass.runner.run.simulate import simulate


@pytest.mark.parametrize("chunk", [333, 1 << 16])
def test_envelopes_and_measures_are_those_of_a_run(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_CHUNK", chunk)
    graph = read_graph(library_file("template.toml"))
    ticks, pixels = 4200, 60
    told = list[dict[str, Any]]()
    module.long_run(graph, ticks, 11, pixels, told.append, threading.Event())
    result = simulate(graph, samples=ticks, seed=11)
    assert told[-1]["done"] == ticks
    assert told[-1]["measures"] == {name: measure.value for name, measure in result.measures.items()}
    for picture in told[-1]["pictures"]:
        trace = result[picture["signal"]]
        parts = np.asarray(trace.values, dtype=float).reshape(pixels, -1)
        falls = parts.argmax(axis=1) < parts.argmin(axis=1)
        low, high = parts.min(axis=1), parts.max(axis=1)
        np.testing.assert_array_equal(picture["y"][::2], np.where(falls, high, low))
        np.testing.assert_array_equal(picture["y"][1::2], np.where(falls, low, high))
        times = trace.times.reshape(pixels, -1)
        np.testing.assert_allclose(picture["x"][::2], times[:, 0], rtol=1e-12, atol=1e-12)


@pytest.mark.defect("S929", before="rows of a clock offset of 5 ms were drawn from 0", after="where they are")
def test_a_late_clock_is_drawn_late() -> None:
    blocks = {"source": Ramp(), "late": Gain(gain=1.0)}
    graph = Graph(
        name="late",
        rate=1000,
        blocks=blocks,
        wires=["source.output -> late.input"],
        probes=["late.output"],
        rates={"late": 100},
        offsets={"late": "5 ms"},
    )
    told = list[dict[str, Any]]()
    module.long_run(graph, 26, 1, 3, told.append, threading.Event())
    (picture,) = told[-1]["pictures"]
    assert picture["x"][::2] == pytest.approx([0.005, 0.015, 0.025])
    assert picture["y"][::2] == pytest.approx([0.005, 0.015, 0.025])


def test_a_run_that_is_stopped_says_no_more() -> None:
    told, stop = list[dict[str, Any]](), threading.Event()
    stop.set()
    module.long_run(read_graph(library_file("template.toml")), 10**9, 1, 100, told.append, stop)
    assert told == []
