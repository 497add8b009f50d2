"""The commands that compare and verify; what they do is imported when they are called."""

from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.declarations.options import (
    Whole,
    blocks_option,
    engine_option,
    graph_argument,
    json_option,
    set_option,
)

_ANY = click.Path(path_type=Path)
_FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("before", type=_ANY)
@click.argument("after", type=_ANY)
@click.option(
    "--tolerance",
    "relative",
    type=click.FloatRange(0.0),
    default=0.0,
    show_default=True,
    help="Allow this difference of traces and measures, relative to the largest value before.",
)
@click.option(
    "--absolute",
    type=click.FloatRange(0.0),
    default=0.0,
    show_default=True,
    help="Allow this difference of traces and measures, in their units.",
)
@click.option("--html", "page", type=_FILE, metavar="FILE", help="Write the tables as one HTML file.")
@blocks_option
@json_option
def diff(**options: Any) -> int:
    """Show how two graphs, two runs or two studies differ.

    BEFORE and AFTER are graph files, which are compared by what they mean, or folders that `run --out` or `montecarlo
    --out` wrote. Of studies the answer says which means and yields moved by more than sensors scatter. Exit code 1 if
    something differs.

    \b
    proofmass diff sensor.toml new_sensor.toml
    proofmass diff results new_results --tolerance 1e-9
    proofmass diff drift new_drift --html changes.html
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.diff_command import DiffRequest, show_differences

    return show_differences(DiffRequest(**options))


@click.command()
@graph_argument
@click.option(
    "--runs", type=Whole(1, 2**32), help="Simulate this many sensors for yields (default: as the study says)."
)
@click.option("--record", is_flag=True, help="Record measures and margins as golden results, beside the graph.")
@click.option(
    "--golden",
    type=_FILE,
    metavar="FILE",
    help="Compare with these golden results, or record them there (default: GRAPH.golden.json, if it is there).",
)
@click.option("--junit", type=_FILE, metavar="FILE", help="Write the findings as JUnit XML.")
@click.option("--html", "page", type=_FILE, metavar="FILE", help="Write the findings as one HTML file.")
@engine_option()
@set_option
@blocks_option
@json_option
def verify(**options: Any) -> int:
    """Check a graph against its requirements and golden results.

    Requirements are those of the table [requirements] and of the loops; a run, margins and the study are computed if
    one needs them. Exit code 1 if one is missed.

    \b
    proofmass verify sensor.toml --junit findings.xml
    proofmass verify sensor.toml --record
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.verify_command import VerifyRequest, verify_graph

    return verify_graph(VerifyRequest(**options))


COMPARISONS = (diff, verify)
