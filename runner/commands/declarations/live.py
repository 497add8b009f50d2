"""The command `live`."""

from pathlib import Path

from proofmass.runner.commands.declarations.options import (
    OWN,
    PROBES,
    SET,
    Request,
    file_argument,
    file_option,
    option,
)


class LiveRequest(Request, does="live_command.serve_live"):
    """Show a graph in the browser, and update it after every save.

    The page has a slider for each parameter; traces, spectra, measures, margins and noise follow. It is served to this
    machine alone. Mistakes in the file are shown with their lines, above the last good run.

    \b
    proofmass live sensor.toml
    proofmass live sensor.toml --no-browser
    proofmass live sensor.toml --study drift.toml
    """

    graph: Path = file_argument(library=True)
    changes: tuple[str, ...] = SET
    probes: tuple[str, ...] = PROBES
    study: Path | None = file_option("Run this study meanwhile (default: that of the graph file, if it has one).")
    browser: bool = option("Open the page in a browser.", "--browser/--no-browser", default=True, show_default=True)
    own: Path | None = OWN


LIVE = (LiveRequest,)
