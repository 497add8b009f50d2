"""Arguments and options that several commands have."""

from pathlib import Path

import click

graph_argument = click.argument("graph", type=click.Path(dir_okay=False, path_type=Path))
blocks_option = click.option(
    "--blocks",
    "own",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Python file of your own blocks; it is run.",
)
set_option = click.option(
    "--set", "changes", multiple=True, metavar="BLOCK.PARAMETER=VALUE", help="Change a parameter."
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
