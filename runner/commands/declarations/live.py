"""The command `live`."""

from pathlib import Path

from proofmass.runner.commands.declarations.options import (
    OWN,
    PROBES,
    SET,
    LibraryFile,
    Request,
    file_argument,
    flag,
    option,
)


class LiveRequest(Request, does="live_command.serve_live"):
    """Show a graph in the browser, and update it after every save.

    The page has a slider for each parameter; traces, spectra, measures, margins and noise follow. It is served to this
    machine alone. Mistakes in the file are shown with their lines, above the last good run.

    \b
    proofmass live library:closed_loop_accelerometer
    proofmass live library:closed_loop_accelerometer --no-browser
    proofmass live library:scale_factor_drift --study library:margin_tolerance_study
    """

    graph: Path = file_argument(library=True)
    changes: tuple[str, ...] = SET
    probes: tuple[str, ...] = PROBES
    study: Path | None = option(
        "Run this study meanwhile (default: that of the graph file, if it has one).",
        type=LibraryFile(dir_okay=False, path_type=Path),
        metavar="FILE",
    )
    edit: bool = flag("Let the page save its sliders into the file, which it does not write otherwise.")
    browser: bool = option("Open the page in a browser.", "--browser/--no-browser", default=True, show_default=True)
    own: Path | None = OWN
