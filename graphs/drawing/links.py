"""Wires of a picture whose ends exist, and what each block has wired."""

from collections.abc import Collection

from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.picture import TAB, Picture
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
    """Wired ports and parameters of each block with their sources, its wired outputs and its probed ones.

    `tabs` has for each block the ports whose wires are named instead of drawn, with those names.
    `leaves` and `enters` are the blocks at which bundles begin and end.
    """

    def __init__(
        self, graph: Picture, links: list[Link], named: Collection[Link] = (), bundled: Collection[Link] = ()
    ) -> None:
        self.into: dict[str, dict[str, str]] = {name: {} for name in graph.blocks}
        self.probed: dict[str, set[str]] = {name: set() for name in graph.blocks}
        self.used: dict[str, set[str]] = {name: set() for name in graph.blocks}
        for link in links:
            self.into[link.target][link.port] = f"{link.source}.{link.output}"
            self.used[link.source].add(link.output)
        self.tabs: dict[str, dict[str, str]] = {name: {} for name in graph.blocks}
        for name, port in probed(graph):
            self.probed[name].add(port)
            self.used[name].add(port)
        for link in named:
            self.tabs[link.target][link.port] = self.net_label(link)
            if graph.blocks[link.source].kind:  # else it is a tab already
                self.tabs[link.source][link.output] = self.net_label(link)
        self.leaves, self.enters = {link.source for link in bundled}, {link.target for link in bundled}
        driving = sorted({(link.source, link.output) for link in links if link.driven})
        self.net_of = {net: number for number, net in enumerate(driving)}  # of the wires that drive parameters

    def net_label(self, link: Link) -> str:
        """Return the name of a net on its tabs: its block, with the output where others of the block are in use too."""
        name = link.source.strip(TAB)
        return name if len(self.used[link.source]) == 1 else f"{name}.{link.output}"
