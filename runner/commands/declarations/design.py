"""The commands that find parameters; what they do is imported when they are called."""

from pathlib import Path
from typing import Any

import click

from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.runner.commands.completion import outputs
from proofmass.runner.commands.declarations.options import (
    Whole,
    blocks_option,
    file_argument,
    graph_argument,
    json_option,
    plot_option,
    quiet_option,
    set_option,
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
@click.option("--starts", type=Whole(1, 100), help="Start from this many samples (default: as the graph says).")
@click.option("--samples", type=Whole(1, 100_000), help="Try this many points first (default: as the graph says).")
@click.option("--seed", type=Whole(0, LARGEST_SEED), help="Seed these points (default: as the graph says).")
@set_option
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
    proofmass tune sensor.toml --set adc.bits=12
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.tune_command import TuneRequest, show_tuning

    return show_tuning(TuneRequest(**options))


@click.command()
@file_argument("source", library=True)
@click.option(
    "--figure",
    "figures",
    multiple=True,
    metavar="LOOP:FIGURE",
    help="Find the worst case of this figure, as main:phase_margin; repeatable.",
)
@click.option(
    "--noise",
    "noises",
    multiple=True,
    metavar="BLOCK.PORT",
    shell_complete=outputs,
    help="Find the worst noise of this output.",
)
@click.option(
    "--scale-factor",
    "scale_factors",
    multiple=True,
    metavar="BLOCK.PORT",
    shell_complete=outputs,
    help="Find the worst scale factor of this output.",
)
@click.option(
    "--bias",
    "biases",
    multiple=True,
    metavar="BLOCK.PORT",
    shell_complete=outputs,
    help="Find the worst value of this output at zero input.",
)
@click.option(
    "--response",
    "responses",
    multiple=True,
    metavar="BLOCK.PORT:FIGURE",
    help="Find the worst response of this output, as adc.number:bandwidth or adc.number:gain@100Hz; repeatable.",
)
@click.option(
    "--measure", "measures", multiple=True, metavar="NAME", help="Find the worst case of this measure; repeatable."
)
@click.option(
    "--yield",
    "yields",
    multiple=True,
    metavar="LIMIT",
    help='Find the worst yield of the study for this limit of it, or "all", within --tolerance; repeatable.',
)
@click.option(
    "--input",
    "source_signal",
    default="",
    metavar="BLOCK.PORT",
    shell_complete=outputs,
    help="Count scale factors and responses from this output of a source, and refer noise to it.",
)
@click.option(
    "--band", nargs=2, metavar="FROM TO", help='Count noise within this band, as "1 Hz" "100 Hz" (default: all).'
)
@click.option(
    "--tolerance",
    "tolerances",
    multiple=True,
    metavar="PARAMETER=WIDTH",
    help='Vary a parameter by "5 %", by "0.1 V", or within "4.9 V..5.2 V"; repeatable.',
)
@click.option("--at", default="", metavar="TIME", help='Linearise at this time, or "settled" (default: the start).')
@click.option(
    "--corners",
    type=Whole(0, 2**20),
    default=256,
    show_default=True,
    help="Try all corners if there are no more than this.",
)
@click.option("--samples", type=Whole(1, 10**6), default=100, show_default=True, help="Try this many random points.")
@click.option("--seed", type=Whole(0, LARGEST_SEED), help="Seed the random points (default: 0).")
@click.option(
    "--runs",
    type=Whole(1, 10**9),
    help="Run this many sensors of the study and show their yields too (default: none).",
)
@plot_option("picture", "Draw the effect of each parameter alone, and of all together")
@set_option
@quiet_option
@blocks_option
@json_option
def worst(**options: Any) -> int:
    """Find how bad a graph can get within tolerances.

    SOURCE is a graph, or a study, whose spread counts as tolerances: three standard deviations of normal parameters.
    The answer has the worst case of each quantity, the effect of each parameter alone, and the number of points tried.
    Without a quantity it takes the gain and phase margins of all named loops.

    \b
    proofmass worst graphs/library/accelerometer/margin_tolerance_study.toml
    proofmass worst sensor.toml --tolerance "torquer.gain=5 %" --figure main:phase_margin --plot worst.png
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.worst_command import WorstRequest, show_worst

    return show_worst(WorstRequest(**options))


DESIGN = (tune, worst)
