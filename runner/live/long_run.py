"""A run that is too long for a page: the process computes it, and tells its lowest and highest rows per pixel."""

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from proofmass.graphs.model.graph import Graph
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.measuring import measured
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import PlannedProbe
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.recorder import room
from proofmass.runner.targets.native import CompiledLoop

MOST_PIXELS = 4000
_CHUNK = 1 << 16  # ticks
_TOLD = 0.3  # seconds from one message to the next

Tell = Callable[[dict[str, Any]], None]


class Envelope:
    """The lowest and highest row of a signal in each of so many stretches of a run."""

    def __init__(self, probe: PlannedProbe, ticks: int, pixels: int) -> None:
        self.probe, self.rows = probe, probe.rows(0, ticks)
        self.pixels = max(1, min(pixels, self.rows))
        self.low, self.high = np.full(self.pixels, np.inf), np.full(self.pixels, -np.inf)
        self.lowest, self.highest = np.zeros((2, self.pixels), dtype=np.int64)  # rows of these
        self.done = 0

    def add(self, values: AnyArray) -> None:
        """Add the next rows."""
        numbers = np.asarray(values, dtype=float)
        if self.probe.format is not None:
            numbers = numbers * 2.0**-self.probe.format.fraction
        pixel = (np.arange(self.done, self.done + len(numbers)) * self.pixels) // max(1, self.rows)
        ways = (np.fmin, self.low, self.lowest), (np.fmax, self.high, self.highest)
        for extreme, values_so_far, rows in ways:
            before = values_so_far.copy()
            extreme.at(values_so_far, pixel, numbers)
            new = np.flatnonzero((numbers == values_so_far[pixel]) & (values_so_far != before)[pixel])[::-1]
            rows[pixel[new]] = self.done + new  # the first of equal ones is written last
        self.done += len(numbers)

    def as_data(self, period: float) -> dict[str, Any]:
        """Return a picture as the page draws it, by the base period: two points in order for each stretch begun."""
        begun = np.isfinite(self.low) & np.isfinite(self.high)
        edges = (np.arange(self.pixels + 1) * self.rows / self.pixels * self.probe.stride + self.probe.phase) * period
        x = np.stack([edges[:-1], (edges[:-1] + edges[1:]) / 2.0], axis=1)[begun]
        falls = (self.highest < self.lowest)[:, None]
        y = np.where(falls, np.stack([self.high, self.low], axis=1), np.stack([self.low, self.high], axis=1))[begun]
        return {"signal": self.probe.signal, "x": x.ravel().tolist(), "y": y.ravel().tolist()}


def long_run(graph: Graph, ticks: int, seed: int, pixels: int, tell: Tell, stop: threading.Event) -> None:
    """Run a graph from tick 0, and tell how its scalar probes look until now; at the end the measures too."""
    planned = plan(graph)
    engine = CompiledLoop(planned, seed, memory=start(planned))
    period = float(1 / planned.schedule.base_rate)
    envelopes = {
        probe.signal: Envelope(probe, ticks, min(pixels, MOST_PIXELS)) for probe in planned.probes if not probe.shape
    }
    began = told = time.monotonic()
    sound, tick = True, 0
    while tick < ticks and sound and not stop.is_set():
        last = min(ticks, tick + _CHUNK)
        rows = room(planned, tick, last)
        sound, tick = engine.advance(last, rows), last
        for probe, values in zip(planned.probes, rows, strict=True):
            if probe.signal in envelopes:
                envelopes[probe.signal].add(values)
        if time.monotonic() - told > _TOLD:
            told = time.monotonic()
            tell({"done": tick, "ticks": ticks, "pictures": _pictures(envelopes, period)})
    if stop.is_set():
        return
    measures = {name: one.value for name, one in measured(planned, engine.memory()).items() if one.value == one.value}
    whole = {"done": tick, "ticks": ticks, "pictures": _pictures(envelopes, period), "sound": sound}
    tell(whole | {"measures": measures, "seconds": time.monotonic() - began})


def _pictures(envelopes: dict[str, Envelope], period: float) -> list[dict[str, Any]]:
    return [one.as_data(period) for one in envelopes.values()]
