"""The command `live`; what it does is imported when it is called."""

from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.declarations.options import blocks_option, graph_argument, probe_option, set_option


@click.command()
@graph_argument
@set_option
@probe_option
@click.option(
    "--study",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Run this study meanwhile (default: that of the graph file, if it has one).",
)
@click.option("--browser/--no-browser", default=True, show_default=True, help="Open the page in a browser.")
@blocks_option
def live(**options: Any) -> int:
    """Show a graph in the browser, and update it after every save.

    The page has a slider for each parameter; traces, spectra, measures, margins and noise follow. It is served to this
    machine alone. Mistakes in the file are shown with their lines, above the last good run.

    \b
    proofmass live sensor.toml
    proofmass live sensor.toml --no-browser
    proofmass live sensor.toml --study drift.toml
    """
    # start-up time: NumPy and LLVM
    from proofmass.runner.commands.live_command import LiveRequest, serve_live

    return serve_live(LiveRequest(**options))
