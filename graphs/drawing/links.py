"""Wires of a picture whose ends exist, and what each block has wired."""

from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.picture import Picture
from proofmass.graphs.model.rates import write_rate


def links_of(graph: Picture) -> list[Link]:
    """Return the wires whose ends exist, each once."""
    links = set()
    for (source, output), (target, port) in graph.wires:
        if source in graph.blocks and target in graph.blocks and output in graph.blocks[source].outputs:
            block = graph.blocks[target]
            if port in block.inputs or port in block.parameters:
                links.add(Link(source, output, target, port, port not in block.inputs))
    return sorted(links)


def probed(graph: Picture) -> list[tuple[str, str]]:
    """Return the probed outputs that exist, by block and port."""
    return [(name, port) for name, port in graph.probes if name in graph.blocks and port in graph.blocks[name].outputs]


def rate_text(graph: Picture, name: str) -> str:
    """Return the rate of a block if it differs from the graph's."""
    rate = graph.rates.get(name)
    return "" if rate is None or rate == graph.rate else write_rate(rate)


class WiredPorts:
    """Wired ports and parameters of each block with their sources, its wired outputs and its probed ones."""

    def __init__(self, graph: Picture, links: list[Link]) -> None:
        self.into: dict[str, dict[str, str]] = {name: {} for name in graph.blocks}
        self.probed: dict[str, set[str]] = {name: set() for name in graph.blocks}
        self.used: dict[str, set[str]] = {name: set() for name in graph.blocks}
        for link in links:
            self.into[link.target][link.port] = f"{link.source}.{link.output}"
            self.used[link.source].add(link.output)
        for name, port in probed(graph):
            self.probed[name].add(port)
            self.used[name].add(port)
        driving = sorted({(link.source, link.output) for link in links if link.driven})
        self.net_of = {net: number for number, net in enumerate(driving)}  # of the wires that drive parameters
