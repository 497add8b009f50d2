"""Commands that show and test blocks and give graphs to start from; what they do is imported when they are called."""

from pathlib import Path
from typing import Any

import click

from proofmass.runner.commands.completion import codes, exhibits, kinds, of_names
from proofmass.runner.commands.declarations.options import blocks_option, file_argument, json_option


@click.command("test-block")
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("kind", nargs=-1)
@json_option
def test_block(file: Path, kind: tuple[str, ...], as_json: bool) -> int:
    """Test the blocks of a Python file, which is run.

    Each block is checked: documents, units, bounds, what compiled code can take, and the same bits in plain Python,
    machine code, lanes, C99 and WebAssembly, on ordinary numbers and at the edges of arithmetic. Exit code 1 if a
    check fails.

    \b
    proofmass test-block my_blocks.py
    proofmass test-block my_blocks.py MovingMean --json
    """
    from proofmass.runner.commands.test_block_command import test_blocks  # start-up time

    return test_blocks(file, kind, as_json)


@click.command()
@click.argument("code", nargs=-1, shell_complete=of_names(codes))
@json_option
def explain(code: tuple[str, ...], as_json: bool) -> int:
    """Explain codes of messages: cause and cure. Without a code it lists all.

    \b
    proofmass explain P0301
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.explain_command import explain_codes

    return explain_codes(code, as_json)


@click.command()
@click.argument("kind", required=False, shell_complete=of_names(kinds))
@click.option("--find", "words", metavar="WORDS", help="List only blocks that all these words describe.")
@click.option("--example", is_flag=True, help="Print a small runnable graph around the block instead.")
@blocks_option
@json_option
def blocks(**options: Any) -> int:
    """List all kinds of blocks by family, or describe one.

    The description has equation, parameters, ports, and lines for a graph file.

    \b
    proofmass blocks
    proofmass blocks --find "phase detector"
    proofmass blocks MassSpringDamper
    proofmass blocks PID --example > example.toml
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.blocks_command import BlocksRequest, show_blocks

    return show_blocks(BlocksRequest(**options))


@click.command()
@click.argument("name", required=False, shell_complete=of_names(exhibits))
@json_option
def gallery(name: str | None, as_json: bool) -> int:
    """List the graphs of the library, or describe one.

    Each is a sensor, or a part of one, to run as it is or to start from with `proofmass new --from`.

    \b
    proofmass gallery
    proofmass gallery closed_loop_gyroscope
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.gallery_command import show_gallery

    return show_gallery(name, as_json)


@click.command()
@file_argument("file")
@click.option(
    "--from",
    "name",
    metavar="NAME",
    shell_complete=of_names(exhibits),
    help="Copy this graph of `proofmass gallery` (default: a template).",
)
def new(file: Path, name: str | None) -> int:
    """Write a graph to start from.

    It is ready to run. What a graph of the gallery names beside it, such as a recording, is copied too, and so is
    proofmass-graph.json, with which editors complete it. A file that exists is not overwritten.

    \b
    proofmass new sensor.toml && proofmass run sensor.toml
    proofmass new gyroscope.toml --from closed_loop_gyroscope
    """
    # start-up time: a command imports what it needs itself
    from proofmass.runner.commands.new_command import write_new_graph

    return write_new_graph(file, name)


BLOCKS = (blocks, explain, gallery, new, test_block)
