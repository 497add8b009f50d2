"""The commands that show and test blocks and give graphs to start from."""

from pathlib import Path

import click

from proofmass.runner.commands.declarations.completion import codes, exhibits, kinds, of_names
from proofmass.runner.commands.declarations.options import (
    JSON,
    Answered,
    Request,
    argument,
    file_argument,
    flag,
    option,
)


class TestBlockRequest(Request, does="test_block_command.test_blocks"):
    """Test the blocks of a Python file, which is run.

    Each block is checked: documents, units, bounds, what compiled code can take, and the same bits
    in plain Python, machine code, lanes, C99 and WebAssembly, on ordinary numbers and at the edges
    of arithmetic. Exit code 1 if a check fails.

    \b
    proofmass new sensor.py
    proofmass test-block sensor.py
    proofmass test-block sensor.py Readout --json
    """

    file: Path = argument(type=click.Path(exists=True, dir_okay=False, path_type=Path))
    kind: tuple[str, ...] = argument(nargs=-1)
    as_json: bool = JSON


class ExplainRequest(Request, does="explain_command.explain_codes"):
    """Explain codes of messages: cause and cure. Without a code it lists all.

    \b
    proofmass explain P0301
    """

    code: tuple[str, ...] = argument(nargs=-1, shell_complete=of_names(codes))
    as_json: bool = JSON


class BlocksRequest(Answered, does="blocks_command.show_blocks"):
    """List all kinds of blocks by family, or describe one.

    The description has equation, parameters, ports, and lines for a graph file.

    \b
    proofmass blocks
    proofmass blocks --find "phase detector"
    proofmass blocks MassSpringDamper
    proofmass blocks PID --example > example.toml
    """

    kind: str | None = argument(required=False, shell_complete=of_names(kinds))
    words: str | None = option("List only blocks that all these words describe.", "--find", metavar="WORDS")
    example: bool = flag("Print a small runnable graph around the block instead.")


class GalleryRequest(Request, does="gallery_command.show_gallery"):
    """List the graphs of the library, or describe one.

    Each is a sensor, or a part of one, to run as it is or to start from with `proofmass new
    --from`.

    \b
    proofmass gallery
    proofmass gallery closed_loop_gyroscope
    """

    name: str | None = argument(required=False, shell_complete=of_names(exhibits))
    as_json: bool = JSON


class NewRequest(Request, does="new_command.write_new_graph"):
    """Write a graph to start from.

    It is ready to run. What a graph of the gallery names beside it, such as a recording, is copied
    too, and so is proofmass-graph.json, with which editors complete it. A file that exists is not
    overwritten. A FILE that ends in
    .py is a graph in Python, with a block of its own.

    \b
    proofmass new sensor.toml && proofmass run sensor.toml
    proofmass new gyroscope.toml --from closed_loop_gyroscope
    proofmass new sensor.py
    """

    file: Path = file_argument()
    name: str | None = option(
        "Copy this graph of `proofmass gallery` (default: a template).",
        "--from",
        metavar="NAME",
        shell_complete=of_names(exhibits),
    )

    def check(self) -> None:
        if self.name is not None and self.file.suffix == ".py":
            raise click.UsageError(f"--from copies TOML: proofmass new {self.file.stem}.toml --from {self.name}")
