"""A run as text for people and as plain data for `--json`."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.rates import write_rate
from proofmass.runner.commands.answers import print_json, print_text
from proofmass.runner.output.counts import count
from proofmass.runner.output.text_table import text_table
from proofmass.runner.output.times import time_text
from proofmass.runner.plan.measuring import FORMULA
from proofmass.runner.run.result import Result

if TYPE_CHECKING:
    from proofmass.runner.run.profile import Profile

_HEAD = ("signal", "unit", "rows", "mean", "std", "min", "max", "last")
_LONGEST = 300  # characters of a line about the integration


def show_run(result: Result, as_json: bool, profiled: "Profile | None" = None) -> None:
    """Print a run as text, or as JSON, with its profile if there is one."""
    if as_json:
        print_json(run_data(result) | ({"profile": profiled.as_data()} if profiled else {}))
        return
    print_text(run_lines(result))
    if profiled:
        print_text(profile_lines(profiled))


def run_lines(result: Result) -> Iterator[str]:
    """Yield length and speed of a run, its signals as a table, its overflows and measures."""
    seconds = float(max(result.ticks - 1, 0) / result.base_rate)
    rate, engine = write_rate(result.base_rate), result.provenance["engine"]
    tick = time_text(result.seconds / max(result.ticks, 1))
    yield f"{result.graph.name}: {count(result.ticks, 'tick')} at {rate} ({time_text(seconds)}), {engine} engine"
    yield f"prepared in {time_text(result.preparation)}, ran in {time_text(result.seconds)}: {tick} a tick"
    if "handed_over" in result.provenance:
        yield f"machine code took over from {result.provenance['handed_over'].removeprefix('by ')}"
    integration = result.provenance.get("integration")
    if integration:
        short = integration if len(integration) <= _LONGEST else f"{integration[: _LONGEST - 4]} ..."
        yield f"continuous blocks {short}"
    if rows := list(result.shown_rows()):
        yield from ("", *text_table([_HEAD, *rows], left=(0, 1)), "")
        yield f"SHA-256 of the traces: {result.digest}"
    yield from _overflows(result)
    yield from _measures(result)


def run_data(result: Result) -> dict[str, Any]:
    """Return a run as plain data."""
    return {
        "graph": result.graph.name,
        "ticks": result.ticks,
        "interrupted": result.interrupted,
        "digest": result.digest,
        "base_rate_hz": float(result.base_rate),
        "seed": result.seed,
        "seconds": result.seconds,
        "preparation_seconds": result.preparation,
        "signals": result.summary(),
        "overflows": dict(result.overflows),
        "measures": {name: measure.as_data() for name, measure in result.measures.items()},
        **result.provenance,
    }


def profile_lines(profile: "Profile") -> Iterator[str]:
    """Yield the time of each phase, then that of each part of a tick alone."""
    whole = sum(profile.phases.values())
    notes = {"compile": "kept from an earlier run: loaded only" if profile.compiled_before else ""}
    rows = [
        (name, time_text(seconds), f"{100 * seconds / whole:.1f} %", notes.get(name, ""))
        for name, seconds in profile.phases.items()
    ]
    yield from ("", *text_table([("phase", "time", "share", ""), *rows], left=(0, 3)), "")
    alone = sum(part.nanoseconds for part in profile.parts)
    parts = [
        (part.name, f"{part.nanoseconds:.1f}", f"{part.error:.1f}", f"{100 * part.nanoseconds / (alone or 1.0):.1f} %")
        for part in profile.parts
    ]
    head = ("part of a tick", "ns a tick", "±", "share")
    yield from text_table([head, *parts], left=(0,))
    why = ", since a processor overlaps them" if alone > profile.tick else ", its start and end included"
    yield f"each part alone, {alone:.1f} ns together; the loop takes {profile.tick:.1f} ns a tick{why}"
    yield f"timed over {profile.ticks:,} ticks; the clock's own {profile.clock:.1f} ns are taken off each part"


def _overflows(result: Result) -> Iterator[str]:
    """A line for each block whose values did not fit; one that is meant to wrap is not a fault."""
    blocks = flatten(result.graph).blocks
    for name, ticks in result.overflows.items():
        of = f"{ticks:,} of its {result.overflow_ticks.get(name, result.ticks):,} ticks"
        if ticks and getattr(blocks.get(name), "overflow", "") == "wrap":
            yield f'{name}: wrapped in {of}, as its overflow = "wrap" says'
        elif ticks:
            yield f"{name}: a value did not fit its format in {of}"


def _measures(result: Result) -> Iterator[str]:
    for name, measure in result.measures.items():
        derived = measure.statistic == FORMULA
        of = measure.signal if derived else f"{measure.statistic} of {measure.signal}"
        if math.isnan(measure.value) and derived:
            yield f"{name} has no value: {of}; one of its measures has none, or it divides by zero"
        elif math.isnan(measure.value) and measure.statistic == "settling_time":
            yield f"{name} has no value: {measure.signal} is not settled at the end of the run; run longer"
        elif math.isnan(measure.value):
            yield f"{name} has no value: the run is too short for the {of}; run longer, or measure from earlier"
        else:
            yield f"{name} = {measure.text()}: {of}"
