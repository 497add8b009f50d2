"""The command that tests blocks; what it does is imported when it is called."""

from pathlib import Path

import click

from proofmass.runner.commands.options import json_option


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


BLOCKS = (test_block,)
