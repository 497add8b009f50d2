"""The commands that find parameters; what they do is imported when they are called."""

from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.options import (
    LARGEST_SEED,
    blocks_option,
    graph_argument,
    json_option,
    plot_option,
    quiet_option,
)

_FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@graph_argument
@click.option(
    "--write",
    "target",
    type=_FILE,
    metavar="FILE",
    help="Write the tuned graph, with its comments, to this file; it may be GRAPH itself.",
)
@plot_option("picture", "Draw parameters, goals and loops before and after")
@click.option(
    "--starts", type=click.IntRange(1, 100), help="Start from this many samples (default: as the graph says)."
)
@click.option("--samples", type=click.IntRange(1, 100_000), help="Try this many points first (default: as it says).")
@click.option("--seed", type=click.IntRange(0, LARGEST_SEED), help="Seed these points (default: as it says).")
@quiet_option
@blocks_option
@json_option
def tune(**options: Any) -> int:
    """Find parameters that meet the goals of a graph.

    GRAPH has a table [tune]: free parameters with bounds, and goals for margins, noise, scale factor or measures.
    The answer says which goal binds. Exit code 1 if no parameters meet all hard goals. Ctrl-C ends the search; the
    best point so far is the answer.

    \b
    proofmass tune sensor.toml
    proofmass tune sensor.toml --plot tuned.png --write sensor.toml
    """
    from proofmass.runner.commands.tune_command import TuneRequest, show_tuning

    return show_tuning(TuneRequest(**options))


DESIGN = (tune,)
