"""The command `montecarlo`: read, run what is left, show, draw, write; or replay one run."""

import contextlib
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from proofmass.graphs.studies.ages import age_text, some_of
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.commands.failures import count
from proofmass.runner.commands.progress import progress_bar, time_text
from proofmass.runner.commands.run_command import as_data, own_blocks, show, write
from proofmass.runner.studies.outcome.intervals import concise
from proofmass.runner.studies.shown.points import all_points_text, first_point, parts

if TYPE_CHECKING:
    from proofmass.graphs.studies.study import Study
    from proofmass.runner.run.result import Result
    from proofmass.runner.studies.outcome.result import StudyResult

_COLUMNS = ("mean", "std", "p1", "p50", "p99")


def run_montecarlo(
    study: Path,
    runs: int | None,
    seed: int | None,
    engine: Any,
    threads: int | None,
    lanes: int | None,
    dask: str | None,
    out: Path | None,
    formats: tuple[str, ...],
    run: int | None,
    epoch: int,
    quiet: bool,
    own: Path | None,
    as_json: bool,
    report: bool = True,
) -> int:
    """Everything that `proofmass montecarlo` does; returns the exit code."""
    if dask is not None and threads is not None:
        raise click.UsageError("give --threads or --dask, not both: Dask's workers have threads of their own")
    from proofmass.runner.studies.whole.study import replay, run_study, with_numbers

    loaded = read_study(study, own_blocks(own))
    if run is not None:
        return _show_replay(replay(with_numbers(loaded, runs, seed), run, epoch, engine), out, formats, as_json)
    bar = progress_bar(quiet or as_json, "run")
    with bar or contextlib.nullcontext():
        result = run_study(
            loaded,
            runs=runs,
            seed=seed,
            engine=engine,
            lanes=lanes,
            threads=threads,
            dask=dask,
            folder=out,
            progress=bar,
        )
    click.echo(json.dumps(_data(result), indent=2) if as_json else _text(result))
    if result.interrupted:
        kept = f"kept in {out}" if out is not None else "with --out FOLDER a study can be resumed"
        hint = "\n  hint:     the same command goes on from there" if out is not None else ""
        click.echo(f"interrupted after {len(result.numbers):,} of {result.planned_runs:,} runs; {kept}{hint}", err=True)
        return 130
    if out is not None:
        click.echo(f"written to {out}: {', '.join(_written(result, out, formats, report))}", err=as_json)
    return 0


def _show_replay(result: "Result", out: Path | None, formats: tuple[str, ...], as_json: bool) -> int:
    if as_json:
        click.echo(json.dumps(as_data(result), indent=2))
    else:
        show(result)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        click.echo(f"written to {out}: {', '.join(write(result, out, ('netcdf', *formats)))}", err=as_json)
    return 0


def _written(result: "StudyResult", out: Path, formats: tuple[str, ...], report: bool) -> list[str]:
    from proofmass.runner.output.export import whole_file
    from proofmass.runner.studies.kept.folder import STUDY_FILE
    from proofmass.runner.studies.kept.ledger import FILE
    from proofmass.runner.studies.shown.export import save_study_csv, save_study_netcdf, save_study_parquet

    with whole_file(out / "study.json") as file:
        file.write((json.dumps(_data(result), indent=2) + "\n").encode())
    tables = {"csv": save_study_csv, "parquet": save_study_parquet}
    save_study_netcdf(result, out / "study.nc")
    made = [tables[form](result, out / f"study.{form}").name for form in formats]
    numbers = [FILE, STUDY_FILE, "study.json", "study.nc", *made]
    return [*numbers, *_shown(result, out, formats)] if report else numbers


def _shown(result: "StudyResult", out: Path, formats: tuple[str, ...]) -> list[str]:
    """Pictures, what scatters the measures, and the report."""
    from proofmass.runner.studies.shown.export_influences import save_influences
    from proofmass.runner.studies.shown.plot import save_study_plot
    from proofmass.runner.studies.shown.report import FILE as REPORT
    from proofmass.runner.studies.shown.report import save_study_report

    return [
        *save_influences(result, out, formats),
        *(save_study_plot(result, out / f"study.{form}").name for form in ("svg", "png")),
        save_study_report(result, out / REPORT).name,
    ]


def _data(result: "StudyResult") -> dict[str, Any]:
    study = result.study
    told_apart = parts(result).values()
    numbered = [(first_point(part), part) for part in told_apart] if len(told_apart) > 1 else []
    points = [{"sweep": _swept(study, point), **_every(study, point), **_found(part)} for point, part in numbered]
    return {
        "graph": study.graph.name,
        "runs": len(result.numbers),
        "planned_runs": result.planned_runs,
        "interrupted": result.interrupted,
        "seed": study.seed,
        "epochs_s": list(study.epochs),
        **_found(result),
        **({"points": points} if points else {}),
        "faults": [{"run": run, "epoch": epoch, "message": text} for (run, epoch), text in result.faults.items()],
        "digest": result.digest,
        "seconds": result.seconds,
        **result.provenance,
    }


def _swept(study: "Study", point: int) -> dict[str, float]:
    return {study.name_of(name): value for name, value in study.point(point).items()}


def _every(study: "Study", point: int) -> dict[str, float | None]:
    every = study.recalibrated_every(point)
    return {"every_s": every if math.isfinite(every) else None} if study.recalibration.carried else {}


def _found(result: "StudyResult") -> dict[str, Any]:
    measures = [_finite(row) for row in result.summary()]
    return {"measures": measures, "yield": result.yields(), "yield_intervals": result.yield_intervals()}


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    """A row for JSON, which has no infinity: null where an interval has no end."""
    ends = {k: [end if math.isfinite(end) else None for end in ends] for k, ends in row.get("intervals", {}).items()}
    return row | ({"intervals": ends} if ends else {})


def _text(result: "StudyResult") -> str:
    study = result.study
    made = len(result.numbers) * len(study.epochs)
    lines = [
        f"{study.graph.name}: {count(len(result.numbers), 'run')}{_at_epochs(study)}, {result.engine} engine,"
        f" {time_text(result.seconds)}",
        "",
    ]
    told_apart = parts(result)
    for name, part in told_apart.items():
        lines += [f"{name}:", ""] if name else []
        lines += [*_table(part), ""]
        yields = part.yield_intervals()
        for name, good in part.yields().items():
            low, high = yields[name]
            confidence = f"with 95 % confidence {100 * low:.2f} to {100 * high:.2f} %"
            lines.append(f"yield, {name}: {100 * good:.2f} %, {confidence}")
        lines += [""] if yields and len(told_apart) > 1 else []
    if len(told_apart) < study.points:
        lines += ["", all_points_text(study)]
    if result.planned_runs < study.runs * study.points:
        lines.append(f"stopped after {result.planned_runs:,} of {study.runs * study.points:,} runs: that was enough")
    if result.faults:
        (run, epoch), text = next(iter(result.faults.items()))
        lines += [f"{len(result.faults):,} of {made:,} failed; run {run} at epoch {epoch}: {text}"]
    return "\n".join(lines).rstrip()


def _at_epochs(study: "Study") -> str:
    return f" at {len(study.epochs)} epochs" if len(study.epochs) > 1 else ""


def _table(result: "StudyResult") -> list[str]:
    """A row per measure and epoch; of many epochs some, the first and the last among them."""
    shown = some_of(result.study.epochs)
    head = ("measure", "unit", "age", *_COLUMNS)
    rows: list[tuple[str, ...]] = [head]
    for row in (row for row in result.summary() if row["age_s"] in shown):
        numbers = [concise(row[key], row["intervals"][key]) if key in row else "" for key in _COLUMNS]
        rows.append((row["measure"], row["unit"], age_text(row["age_s"]), *numbers))
    widths = [max(len(row[i]) for row in rows) for i in range(len(head))]
    lines = []
    for cells in rows:
        left = [cell.ljust(width) for cell, width in zip(cells[:2], widths[:2], strict=True)]
        right = [cell.rjust(width) for cell, width in zip(cells[2:], widths[2:], strict=True)]
        lines.append("  ".join([*left, *right]).rstrip())
    return [*lines, "in brackets half of the 95 % confidence interval, in units of the last digits"]
