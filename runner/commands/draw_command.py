"""The command `draw`: the block diagram of a graph as SVG, Mermaid or DOT."""

from pathlib import Path

import click

from proofmass.graphs.drawing import diagram
from proofmass.runner.commands.answers import write_or_print
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.graph_options import graph_of

_FORMATS = {"svg": diagram.svg, "mermaid": diagram.mermaid, "dot": diagram.dot}
_BY_ENDING = {".svg": "svg", ".mmd": "mermaid", ".mermaid": "mermaid", ".dot": "dot", ".gv": "dot"}


def draw_graph(path: Path, output: Path | None, form: str | None, changes: tuple[str, ...], own: Path | None) -> int:
    """Write the diagram of a graph to a file, or print it, and return the exit code."""
    ending = output.suffix.lower() if output else ".svg"
    if form is None and ending not in _BY_ENDING:
        raise click.UsageError(f"{ending or 'a name without an ending'} is no kind of diagram: {', '.join(_BY_ENDING)}")
    form = form or _BY_ENDING[ending]
    write_or_print(_FORMATS[form](graph_of(path, own, changes)), output)
    return DONE
