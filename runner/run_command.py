"""The command `run`: read, change, simulate, show, write."""

import dataclasses
import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from proofmass.graphs.graph import Graph, read_duration
from proofmass.graphs.rates import write_rate
from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.progress import progress_bar, time_text



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
    if duration and samples:
        raise click.UsageError("give --duration or --samples, not both")
    if resume and out is None:
        raise click.UsageError("--resume needs --out, the folder of the interrupted run")
    if formats and out is None:
        raise click.UsageError("--format needs --out, the folder to write to")
    loaded = _changed(_read(graph, own), changes, probes)
    if show_source:
        return _show_source(loaded)
    from proofmass.runner.checkpoint import load_checkpoint, remove_checkpoint, save_checkpoint
    from proofmass.runner.plan import plan
    from proofmass.runner.simulate import simulate

    restart = None
    if resume and out is not None:
        planned = plan(loaded)
        ticks = planned.ticks(read_duration(duration) if duration else None, samples)
        restart = load_checkpoint(out, planned, loaded.seed if seed is None else seed, ticks)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
    result = simulate(
        loaded,
        duration=duration,
        samples=samples,
        seed=seed,
        engine=engine,
        folder=out,
        progress=progress_bar(quiet or as_json),
        resume=restart,
    )
    if as_json:
        click.echo(json.dumps(_data(result), indent=2))
    else:
        show(result)
    if result.interrupted:
        return _interrupted(result, out, graph, save_checkpoint)
    if out is not None:
        remove_checkpoint(out)
        written = write(result, out, formats or ("netcdf",))
        click.echo(f"written to {out}: {', '.join(written)}", err=as_json)
    return 0


def _read(graph: Path, own: Path | None) -> Graph:
    if own is None:
        return read_graph(graph)
    from proofmass.blocks.catalog import load_own_blocks

    return read_graph(graph, load_own_blocks(own))


def _changed(graph: Graph, changes: tuple[str, ...], probes: tuple[str, ...]) -> Graph:
    values = {}
    for change in changes:
        key, equals, text = change.partition("=")
        if not equals or key.count(".") != 1:
            raise click.UsageError(f"--set {change}: write BLOCK.PARAMETER=VALUE, for example adc.reference=5V")
        try:
            values[key.strip()] = tomllib.loads(f"value = {text}")["value"]
        except ValueError:
            values[key.strip()] = text.strip()
    if values:
        graph = graph.with_parameters(values)
    return dataclasses.replace(graph, probes=(*graph.probes, *probes)) if probes else graph


def _show_source(graph: Graph) -> int:
    from proofmass.runner.generate import generate
    from proofmass.runner.plan import plan

    click.echo(generate(plan(graph)).source)
    return 0


def show(result: Any) -> None:
    seconds = float((result.ticks - 1) / result.base_rate)
    rate = write_rate(result.base_rate)
    engine = result.provenance["engine"]
    click.echo(f"{result.graph.name}: {result.ticks:,} ticks at {rate} ({time_text(seconds)}), {engine} engine")
    click.echo(
        f"prepared in {time_text(result.preparation)}, ran in {time_text(result.seconds)}:"
        f" {time_text(result.seconds / max(result.ticks, 1))} a tick"
    )
    head = ("signal", "unit", "rows", "mean", "std", "min", "max", "last")
    rows = [head]
    for row in result.summary():
        numbers = [f"{row[key]:.9g}" if key in row else "" for key in head[3:7]]
        last = row.get("last", "")
        text = f"[{len(last)} entries]" if isinstance(last, list) else f"{last:.9g}" if last != "" else ""
        rows.append((row["signal"], row["unit"], f"{row['rows']:,}", *numbers, text))
    if len(rows) > 1:
        widths = [max(len(row[i]) for row in rows) for i in range(len(head))]
        click.echo()
        for row in rows:
            left = [cell.ljust(width) for cell, width in zip(row[:2], widths[:2], strict=True)]
            right = [cell.rjust(width) for cell, width in zip(row[2:], widths[2:], strict=True)]
            click.echo("  ".join([*left, *right]).rstrip())
        click.echo()


def _data(result: Any) -> dict[str, Any]:
    return {
        "graph": result.graph.name,
        "ticks": result.ticks,
        "interrupted": result.interrupted,
        "base_rate_hz": float(result.base_rate),
        "seed": result.seed,
        "seconds": result.seconds,
        "preparation_seconds": result.preparation,
        "signals": result.summary(),
        **result.provenance,
    }


def write(result: Any, out: Path, formats: tuple[str, ...], extra: Sequence[tuple[str, str]] = ()) -> list[str]:
    from proofmass.runner import export
    from proofmass.runner.plot import save_plot
    from proofmass.runner.report import save_report

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


def _interrupted(result: Any, out: Path | None, graph: Path, save: Any) -> int:
    if out is None:
        click.echo(f"interrupted after {result.ticks:,} ticks; with --out FOLDER a run can be resumed", err=True)
    else:
        save(result, out)
        click.echo(
            f"interrupted after {result.ticks:,} of {result.planned_ticks:,} ticks; kept in {out}\n"
            "  hint:     the same command with --resume goes on from there",
            err=True,
        )
    return 130


