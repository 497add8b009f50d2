"""Where the signal of an analysis comes from: a run of a graph, or a recording."""

import contextlib
import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.declaration.units import UnitError, convert
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Graph, read_probe
from proofmass.runner.analysis.spectrum.series import Series, of_trace, read_series
from proofmass.runner.commands.progress import progress_bar
from proofmass.runner.commands.run_command import changed, own_blocks

Options = Mapping[str, Any]


def one_signal(source: Path, as_json: bool, options: Options) -> Series:
    """The signal that the options name, without what is to be skipped."""
    whole = _simulated(source, as_json, options) if source.suffix == ".toml" else _recorded(source, options)
    return whole.behind(quantity("--skip", options["skip"], "s"))


def quantity(option: str, text: str, unit: str) -> float:
    """The number of a quantity of the command line."""
    try:
        return convert(text, unit)
    except UnitError as error:
        raise click.UsageError(f"{option} {text}: {error}" + (f"; {error.hint}" if error.hint else "")) from None


def band_of(texts: tuple[str, str] | None) -> tuple[float, float] | None:
    """A band of frequency in Hz."""
    if texts is None:
        return None
    low, high = (quantity("--band", text, "Hz") for text in texts)
    if not 0.0 <= low < high:
        raise click.UsageError(f"--band {texts[0]} {texts[1]}: the second must be above the first")
    return low, high


def _recorded(path: Path, options: Options) -> Series:
    for option in ("duration", "samples", "seed", "changes", "own"):
        if options[option]:
            named = {"changes": "set", "own": "blocks"}.get(option, option)
            raise click.UsageError(f"--{named} is for a graph; {path.name} is read as a recording")
    return read_series(path, options["probe"])


def _simulated(path: Path, as_json: bool, options: Options) -> Series:
    from proofmass.runner.run.simulate import simulate

    if options["duration"] is not None and options["samples"] is not None:
        raise click.UsageError("give --duration or --samples, not both")
    graph = one_probe(changed(read_graph(path, own_blocks(options["own"])), options["changes"], ()), options["probe"])
    bar = progress_bar(as_json)
    with bar or contextlib.nullcontext():
        result = simulate(
            graph,
            duration=options["duration"],
            samples=options["samples"],
            seed=options["seed"],
            engine=options["engine"],
            progress=bar,
        )
    return of_trace(result[graph.probes[0].signal])


def one_probe(graph: Graph, signal: str) -> Graph:
    """The graph with a probe of the signal alone; its only probe where none is named."""
    if not signal and len(graph.probes) != 1:
        names = ", ".join(probe.signal for probe in graph.probes)
        problem = Problem(message="which signal is meant must be said", key="probe", got=names, hint="add --probe BLOCK.PORT")
        raise ModelError([problem])
    try:
        probe = read_probe(signal) if signal else graph.probes[0]
    except UnitError:
        raise click.UsageError(f"--probe {signal}: write BLOCK.PORT, for example adc.number") from None
    return dataclasses.replace(graph, probes=(probe,), measures={})
