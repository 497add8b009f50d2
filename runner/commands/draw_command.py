"""The command `draw`: the block diagram of a graph as SVG, Mermaid or DOT."""

from collections.abc import Sequence

import click

from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.graphs.drawing.diagram import subgraph_paths, svg
from proofmass.graphs.drawing.diagram_data import diagram_data
from proofmass.graphs.drawing.text_forms import dot, mermaid
from proofmass.graphs.model.graph import Graph
from proofmass.runner.commands.answers import DONE, print_json, write_or_print
from proofmass.runner.commands.declarations.graphs import DrawRequest
from proofmass.runner.commands.graph_options import graph_of

_TEXTS = {"mermaid": mermaid, "dot": dot}
_BY_ENDING = {".svg": "svg", ".mmd": "mermaid", ".mermaid": "mermaid", ".dot": "dot", ".gv": "dot"}
_ALL = "all"


def draw_graph(request: DrawRequest) -> int:
    """Write the diagram of a graph to a file, or print it, and return the exit code."""
    output = request.output
    ending = output.suffix.lower() if output else ".svg"
    if request.form is None and ending not in _BY_ENDING:
        raise click.UsageError(f"{ending or 'no ending'} is not a kind of diagram: {', '.join(_BY_ENDING)}")
    form = request.form or _BY_ENDING[ending]
    if form != "svg" and (request.unfold or request.overlay):
        raise click.UsageError(f"--unfold and --overlay need SVG, not {form}")
    graph = graph_of(request.graph, request.own, request.changes)
    unfolded = _unfolded(graph, request.unfold)
    text = _TEXTS[form](graph) if form != "svg" else svg(graph, unfolded, request.overlay or "")
    if request.as_json:
        print_json(diagram_data(graph, unfolded))
    if output is not None or not request.as_json:
        write_or_print(text, output, request.as_json)
    return DONE


def _unfolded(graph: Graph, names: Sequence[str]) -> list[str]:
    """Return the paths of the subgraphs that are named, and those around them."""
    paths = subgraph_paths(graph)
    if _ALL in names and _ALL not in paths:
        return paths
    for name in names:
        if name not in paths:
            hint = did_you_mean(name, paths, "the subgraphs") or "this graph has no subgraphs"
            raise click.UsageError(f"--unfold {name}: there is no such subgraph; {hint}")
    return [path for path in paths if any(f"{name}.".startswith(f"{path}.") for name in names)]
