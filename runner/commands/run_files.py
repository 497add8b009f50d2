"""The files of a run in its folder."""

from collections.abc import Sequence
from pathlib import Path

from proofmass.blocks.declaration.libraries import installed, need
from proofmass.runner.output import export
from proofmass.runner.output.page import STILL, LivePart
from proofmass.runner.output.plot import save_plot
from proofmass.runner.output.report import save_report
from proofmass.runner.run.result import Result


def usual_format(*libraries: str) -> str:
    """Return netCDF, or CSV where one of the libraries that netCDF takes is not installed."""
    return "netcdf" if all(map(installed, ("h5netcdf", *libraries))) else "csv"


def need_for(formats: Sequence[str]) -> None:
    """Raise `MissingLibraryError` before runs whose files could not be written behind them."""
    libraries = {"netcdf": "h5netcdf", "parquet": "pyarrow"}
    need(*(libraries[form] for form in formats if form in libraries))


def write_run(
    result: Result, out: Path, formats: tuple[str, ...], more: Sequence[tuple[str, str]] = (), live: bool = False
) -> list[str]:
    """Write traces, plot, summary and report, with more sections of HTML; returns the names of the files.

    A `live` report carries the loop itself.
    """
    names: list[str] = []
    if result.traces:
        if "netcdf" in formats:
            export.save_netcdf(result, out / "traces.nc")
            names.append("traces.nc")
        if "csv" in formats:
            names += [path.name for path in export.save_csv(result, out)]
        if "parquet" in formats:
            names += [path.name for path in export.save_parquet(result, out)]
        save_plot(result, out / "plot.svg")
        names.append("plot.svg")
    export.save_summary(result, out / "summary.json")
    save_report(result, out / "report.html", more, _live_part(result) if live else STILL)
    return [*names, "summary.json", "report.html"]


def _live_part(result: Result) -> LivePart:
    from proofmass.runner.live.model import live_model, live_part  # start-up time: few reports carry WebAssembly

    return live_part(result.graph, live_model(result.graph, result.planned_ticks, result.seed))
