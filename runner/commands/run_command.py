"""The command `run`: read, change, simulate, show, write."""

import contextlib
import dataclasses
import json
import math
import tomllib
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal
from proofmass.graphs.checks.clocking import notes_of_a_run
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph, read_probe, split
from proofmass.graphs.model.rates import write_rate
from proofmass.runner.commands.progress import progress_bar, time_text

if TYPE_CHECKING:
    from proofmass.blocks.declaration.declare import Block
    from proofmass.runner.run.result import Result


def run_graph(
    graph: Path,
    duration: str | None,
    samples: int | None,
    seed: int | None,
    engine: Any,
    changes: tuple[str, ...],
    probes: tuple[str, ...],
    out: Path | None,
    formats: tuple[str, ...],
    resume: bool,
    show_source: bool,
    quiet: bool,
    own: Path | None,
    as_json: bool,
) -> int:
    """Everything that `proofmass run` does; returns the exit code."""
    if duration is not None and samples is not None:
        raise click.UsageError("give --duration or --samples, not both")
    if resume and out is None:
        raise click.UsageError("--resume needs --out, the folder of the interrupted run")
    if formats and out is None:
        raise click.UsageError("--format needs --out, the folder to write to")
    loaded = changed(read_graph(graph, own_blocks(own)), changes, probes)
    if show_source:
        return _show_source(loaded)
    from proofmass.runner.run.simulate import simulate

    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
    bar = progress_bar(quiet or as_json)
    with bar or contextlib.nullcontext():
        result = simulate(
            loaded,
            duration=duration,
            samples=samples,
            seed=seed,
            engine=engine,
            folder=out,
            progress=bar,
            resume=resume,
        )
    for note in notes_of_a_run(loaded):
        click.echo(str(note), err=True)
    if as_json:
        click.echo(json.dumps(as_data(result), indent=2))
    else:
        show(result)
    if result.interrupted:
        return _interrupted(result, out)
    if out is not None:
        written = write(result, out, formats or ("netcdf",))
        click.echo(f"written to {out}: {', '.join(written)}", err=as_json)
    return 0


def own_blocks(path: Path | None) -> "dict[str, type[Block]] | None":
    """The blocks of a user's own file, which is run; raises `ModelError` when that fails."""
    if path is None:
        return None
    from proofmass.blocks.declaration.catalog import load_own_blocks

    try:
        return load_own_blocks(path)
    except ModelError:
        raise
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == path.resolve()]
        line = error.lineno if isinstance(error, SyntaxError) else lines[-1] if lines else None
        message = f"the file of blocks fails: {type(error).__name__}: {getattr(error, 'msg', error)}"
        raise ModelError([Problem(message=message, file=str(path), line=line or 0)]) from error


def changed(graph: Graph, changes: tuple[str, ...], probes: tuple[str, ...]) -> Graph:
    """The graph with what `--set` and `--probe` say."""
    values = {}
    for change in changes:
        key, equals, text = change.partition("=")
        key = key.strip()
        if not equals or "." not in key:
            raise click.UsageError(f"--set {change}: write BLOCK.PARAMETER=VALUE, for example adc.reference=5V")
        driver = next((wire.source for wire in graph.wires if wire.target == key), "")
        if driver:
            hint = f"change {split(driver)[0]}, or remove the wire"
            raise ModelError(
                [Problem(message=f"is driven by {driver}: a value would change nothing", key=key, hint=hint)]
            )
        try:
            values[key] = tomllib.loads(f"value = {text}")["value"]
        except (ValueError, RecursionError):
            values[key] = text.strip()
    if values:
        graph = graph.with_parameters(values)
    known = {probe.signal for probe in graph.probes}
    added = []
    for signal in dict.fromkeys(probes):
        try:
            added += [read_probe(signal)] if signal not in known else []
        except Refusal:
            raise click.UsageError(f"--probe {signal}: write BLOCK.PORT, for example adc.code") from None
    return dataclasses.replace(graph, probes=(*graph.probes, *added))


def _show_source(graph: Graph) -> int:
    from proofmass.runner.planning.plan import plan
    from proofmass.runner.program.generate import generate

    click.echo(generate(plan(graph)).listing)
    return 0


def show(result: "Result") -> None:
    """Print a run: its length and speed, and a line of statistics per signal."""
    seconds = float(max(result.ticks - 1, 0) / result.base_rate)
    rate = write_rate(result.base_rate)
    engine = result.provenance["engine"]
    click.echo(f"{result.graph.name}: {result.ticks:,} ticks at {rate} ({time_text(seconds)}), {engine} engine")
    click.echo(
        f"prepared in {time_text(result.preparation)}, ran in {time_text(result.seconds)}:"
        f" {time_text(result.seconds / max(result.ticks, 1))} a tick"
    )
    integration = result.provenance.get("integration")
    if integration:
        click.echo(f"continuous blocks {_shortened(integration)}")
    head = ("signal", "unit", "rows", "mean", "std", "min", "max", "last")
    rows: list[tuple[str, ...]] = [head]
    for row in result.summary():
        numbers = [f"{row[key]:.9g}" if key in row else "" for key in head[3:7]]
        last = row.get("last", "")
        text = f"[{len(last)} entries]" if isinstance(last, list) else f"{last:.9g}" if last != "" else ""
        rows.append((row["signal"], row["unit"], f"{row['rows']:,}", *numbers, text))
    if len(rows) > 1:
        widths = [max(len(row[i]) for row in rows) for i in range(len(head))]
        click.echo()
        for cells in rows:
            left = [cell.ljust(width) for cell, width in zip(cells[:2], widths[:2], strict=True)]
            right = [cell.rjust(width) for cell, width in zip(cells[2:], widths[2:], strict=True)]
            click.echo("  ".join([*left, *right]).rstrip())
        click.echo()
    for line in _overflows(result):
        click.echo(line)
    for name, measure in result.measures.items():
        unit = f" {measure.unit}" if measure.unit != "1" else ""
        of = f"{measure.statistic} of {measure.signal}"
        if math.isnan(measure.value):
            click.echo(f"{name} has no value: the run is too short for the {of}; run longer, or measure from earlier")
        else:
            click.echo(f"{name} = {measure.value:.9g}{unit}: {of}")


def _overflows(result: "Result") -> Iterator[str]:
    """A line for each block whose values did not fit; what is meant to wrap is told as that."""
    blocks = flatten(result.graph).blocks
    for name, ticks in result.overflows.items():
        of = f"{ticks:,} of its {result.overflow_ticks.get(name, result.ticks):,} ticks"
        if ticks and getattr(blocks.get(name), "overflow", "") == "wrap":
            yield f'{name}: wrapped in {of}, as its overflow = "wrap" says'
        elif ticks:
            yield f"{name}: a value did not fit its format in {of}"


def _shortened(text: str, limit: int = 300) -> str:
    return text if len(text) <= limit else f"{text[: limit - 4]} ..."


def as_data(result: "Result") -> dict[str, Any]:
    """A run as plain data, for `--json`."""
    return {
        "graph": result.graph.name,
        "ticks": result.ticks,
        "interrupted": result.interrupted,
        "base_rate_hz": float(result.base_rate),
        "seed": result.seed,
        "seconds": result.seconds,
        "preparation_seconds": result.preparation,
        "signals": result.summary(),
        "overflows": dict(result.overflows),
        "measures": {name: measure.as_data() for name, measure in result.measures.items()},
        **result.provenance,
    }


def write(result: "Result", out: Path, formats: tuple[str, ...], extra: Sequence[tuple[str, str]] = ()) -> list[str]:
    """Write traces, plot, summary and report into a folder; returns the names of the files."""
    from proofmass.runner.output import export
    from proofmass.runner.output.plot import save_plot
    from proofmass.runner.output.report import save_report

    written: list[str] = []
    if result.traces:
        if "netcdf" in formats:
            export.save_netcdf(result, out / "traces.nc")
            written.append("traces.nc")
        if "csv" in formats:
            written += [path.name for path in export.save_csv(result, out)]
        if "parquet" in formats:
            written += [path.name for path in export.save_parquet(result, out)]
        save_plot(result, out / "plot.svg")
        written.append("plot.svg")
    export.save_summary(result, out / "summary.json")
    save_report(result, out / "report.html", extra)
    return [*written, "summary.json", "report.html"]


def _interrupted(result: "Result", out: Path | None) -> int:
    if out is None:
        click.echo(f"interrupted after {result.ticks:,} ticks; with --out FOLDER a run can be resumed", err=True)
    else:
        click.echo(
            f"interrupted after {result.ticks:,} of {result.planned_ticks:,} ticks; kept in {out}\n"
            "  hint:     the same command with --resume goes on from there",
            err=True,
        )
    return 130
