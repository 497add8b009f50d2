"""Profile of a run: the time of checking, planning, compiling and the loop, and of each block within a tick.

The loop is run as ever, and timed. Then its ticks are run again by a program with a clock in it, in
many stretches: of each part the lower quartile over the stretches counts, less the cost of the
clock itself: what else a machine does only adds. So a part is timed alone. A processor overlaps
parts that do not wait for each other, so that together they take longer than the loop.
"""

import math
import platform
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.check import check
from proofmass.graphs.model.graph import Graph
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.tick import write_tick
from proofmass.runner.program.timed_tick import CLOCK
from proofmass.runner.run.recorder import room
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunOptions, simulate_plan
from proofmass.runner.targets.machine_code import LlvmModule, is_cached, load_module
from proofmass.runner.targets.native import settings
from proofmass.runner.targets.profiled import ProfiledLoop, can_profile

STRETCHES = 80  # of ticks that are timed
STRETCH = 0.002  # seconds of each, about, so that few are interrupted
FIRST = 64  # ticks of the first one, which is not counted
_MOST_ROWS = 1 << 22  # numbers that a stretch may record
_OF_QUARTILE = 1.3626  # standard error of a quartile of normal numbers, over that of their mean
_OF_DISTANCE = 1.4826  # standard deviation of normal numbers, over the distance of their quartile from their median


@dataclass(frozen=True)
class Part:
    """A part of a tick, alone: a block, a group of continuous blocks, recording, checks, or the loop itself."""

    name: str
    nanoseconds: float  # a tick, on average over all ticks
    error: float  # nanoseconds, standard error


@dataclass(frozen=True)
class Profile:
    """Times of a run; `phases` in seconds, in their order."""

    phases: Mapping[str, float]
    compiled_before: bool  # whether the machine code was loaded, not compiled
    tick: float  # nanoseconds, of the plain loop
    ticks: int  # that were timed for the parts
    clock: float  # nanoseconds that reading the clock takes, which are taken off
    parts: tuple[Part, ...]  # the longest first

    def with_phase(self, name: str, seconds: float, first: bool = False) -> "Profile":
        """Return the profile with one phase more."""
        own = {name: seconds}
        return replace(self, phases={**own, **self.phases} if first else {**self.phases, **own})

    def as_data(self) -> dict[str, Any]:
        """Return the profile as plain data, for JSON."""
        return {
            "seconds": dict(self.phases),
            "compiled_before": self.compiled_before,
            "tick_ns": self.tick,
            "timed_ticks": self.ticks,
            "clock_ns": self.clock,
            "parts": [{"part": p.name, "tick_ns": p.nanoseconds, "error_ns": p.error} for p in self.parts],
        }


def profile(graph: Graph, options: RunOptions) -> tuple[Result, Profile]:
    """Run a graph as machine code and return what came out, with where the time went; raises `ModelError`."""
    if not can_profile():
        message = "parts of a tick are timed on x86-64 only"
        raise Problem(message=message, key="profile", got=platform.machine(), hint="run without --profile").error
    phases: dict[str, float] = {}
    began = time.perf_counter()

    def ends(phase: str) -> None:
        nonlocal began
        now = time.perf_counter()
        phases[phase], began = now - began, now

    wrong = [problem for problem in check(graph) if not problem.note]
    if wrong:
        raise ModelError(wrong)
    ends("check")
    planned = plan(graph)
    ends("plan")
    written = write_tick(planned)
    module = LlvmModule.of(written.program, settings(written))
    before = is_cached(module.key)
    load_module(module)
    ends("compile")
    result = simulate_plan(planned, graph, replace(options, engine="compiled", began=time.perf_counter()))
    ends("run")
    phases["run"] = result.seconds
    clock, ticks, parts = _parts(planned, result.seed, result.ticks)
    return result, Profile(phases, before, 1e9 * result.seconds / max(1, result.ticks), ticks, clock, parts)


def _parts(planned: Plan, seed: int, total: int) -> tuple[float, int, tuple[Part, ...]]:
    """Cost of the clock, ticks that were timed, and the parts of a tick."""
    loop = ProfiledLoop(planned, seed)
    ticks, _, seconds = _stretch(planned, loop, total, FIRST)
    row = sum(math.prod(probe.shape) / probe.stride for probe in planned.probes)
    most = int(_MOST_ROWS / row) if row else total
    length = max(1, min(total, most, int(STRETCH / max(seconds / ticks, 1e-9))))
    rows, timed = [], 0
    for _ in range(STRETCHES):
        ticks, counts, seconds = _stretch(planned, loop, total, length)
        rows.append(counts * (1e9 * seconds / max(1, counts.sum()) / ticks))  # nanoseconds a tick
        timed += ticks
    times = np.array(rows)
    place = loop.parts.index(CLOCK)
    alone = times - times[:, [place]]
    quartile, median = np.quantile(alone, [0.25, 0.5], axis=0)
    errors = _OF_QUARTILE * _OF_DISTANCE * (median - quartile) / math.sqrt(STRETCHES)
    parts = [
        Part(name, max(0.0, float(quartile[i])), float(errors[i])) for i, name in enumerate(loop.parts) if name != CLOCK
    ]
    clock = float(np.quantile(times[:, place], 0.25))
    return clock, timed, tuple(sorted(parts, key=lambda part: (-part.nanoseconds, part.name)))


def _stretch(planned: Plan, loop: ProfiledLoop, total: int, length: int) -> tuple[int, Any, float]:
    """Ticks of a stretch, which starts anew behind the end of the run; what the clock counted, and seconds."""
    if loop.tick >= total:
        loop.restart()
    first = loop.tick
    last = min(total, first + length)
    rows = room(planned, first, last)
    began = time.perf_counter()
    counts = loop.advance(last, rows)
    return last - first, counts, time.perf_counter() - began
