"""The commands that compare; what they do is imported when they are called."""

from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.options import blocks_option, json_option

_ANY = click.Path(exists=True, path_type=Path)
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
    from proofmass.runner.commands.diff_command import DiffRequest, show_differences

    return show_differences(DiffRequest(**options))


COMPARISONS = (diff,)
