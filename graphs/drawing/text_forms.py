"""Diagrams as text for other tools: Mermaid and DOT.

They depend on the graph alone, never on the order in which blocks and wires were declared. Wires
whose ends do not exist are left out: `check` reports them.
"""

from html import escape

from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.links import links_of, probed, rate_text
from proofmass.graphs.drawing.picture import Picture, picture
from proofmass.graphs.drawing.texts import plain, unit_in_print
from proofmass.graphs.model.graph import Graph


def mermaid(whole: Graph) -> str:
    """Return the wiring as a Mermaid flowchart, which many document tools draw."""
    graph = picture(whole)

    def node(name: str) -> str:
        return "block_" + name.replace(".", "__")

    def quoted(*lines: str) -> str:
        return '"' + "<br/>".join(escape(line).replace("&quot;", "#quot;") for line in lines if line) + '"'

    out = ["flowchart LR"]
    for name, block in graph.blocks.items():
        text = quoted(name, block.kind, rate_text(graph, name))
        shape = f"[[{text}]]" if block.subgraph else f"({text})" if block.continuous else f"[{text}]"
        out.append(f"    {node(name)}{shape}")
    for link in links_of(graph):
        arrow = "-.->" if link.driven else "-->"
        out.append(f"    {node(link.source)} {arrow}|{quoted(_edge(graph, link))}| {node(link.target)}")
    for index, (name, port) in enumerate(probed(graph)):
        out += [f"    probe_{index}>{quoted(f'{name}.{port}')}]", f"    {node(name)} --o probe_{index}"]
    return "\n".join(out) + "\n"


def dot(whole: Graph) -> str:
    """Return the wiring as DOT text for Graphviz."""
    graph = picture(whole)

    def quoted(*lines: str) -> str:
        return '"' + "\\n".join(plain(x).replace("\\", "\\\\").replace('"', '\\"') for x in lines if x) + '"'

    out = [f"digraph {quoted(graph.name)} {{", "    rankdir=LR", "    node [shape=box]"]
    for name, block in graph.blocks.items():
        style = ", peripheries=2" if block.subgraph else ", style=rounded" if block.continuous else ""
        out.append(f"    {quoted(name)} [label={quoted(name, block.kind, rate_text(graph, name))}{style}]")
    for link in links_of(graph):
        style = ", style=dashed" if link.driven else ""
        out.append(f"    {quoted(link.source)} -> {quoted(link.target)} [label={quoted(_edge(graph, link))}{style}]")
    for name, port in probed(graph):
        signal = quoted(f"{name}.{port}")
        out += [f"    {signal} [shape=cds]", f"    {quoted(name)} -> {signal} [arrowhead=none]"]
    return "\n".join([*out, "}", ""])


def _edge(graph: Picture, link: Link) -> str:
    unit = unit_in_print(graph.blocks[link.source].outputs[link.output])
    return f"{link.output} → {link.port}" + (f" [{unit}]" if unit else "")
