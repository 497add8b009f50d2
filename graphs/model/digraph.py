"""Directed graphs for networkx, which orders them and finds their loops, parts and ways.

A graph is a mapping from each node to others: those that it needs, or those that it leads to. Nodes that are only
named among the others belong to it too.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeVar

import networkx

Node = TypeVar("Node", bound=Any)  # has a hash and an order


def loops(edges: Mapping[Node, Iterable[Node]]) -> list[set[Node]]:
    """Sets of nodes that all reach each other and themselves."""
    graph = _digraph(edges)
    parts = networkx.strongly_connected_components(graph)
    return [part for part in parts if len(part) > 1 or graph.has_edge(*part, *part)]


def alphabetical(needs: Mapping[Node, Iterable[Node]]) -> Iterator[Node]:
    """The alphabetically first order in which each node comes after all that it needs.

    Raises `networkx.NetworkXUnfeasible` at a loop.
    """
    return iter(networkx.lexicographical_topological_sort(_digraph(turned(needs))))


def connected(nodes: Iterable[Node], edges: Iterable[tuple[Node, Node]]) -> list[set[Node]]:
    """Sets of nodes that hang together, whatever the direction of the edges, in the order of their first nodes."""
    graph: networkx.Graph[Node] = networkx.Graph()
    graph.add_nodes_from(nodes)
    graph.add_edges_from(edges)
    return list(networkx.connected_components(graph))


def reached(edges: Mapping[Node, Iterable[Node]], starts: Iterable[Node]) -> set[Node]:
    """Return the nodes that can be reached from others. A start is among them only if a way leads back to it."""
    return with_following(
        (other for start in starts for other in edges.get(start, ())), lambda node: edges.get(node, ())
    )


def with_following(starts: Iterable[Node], following: Callable[[Node], Iterable[Node]]) -> set[Node]:
    """Return nodes, and all that follow from them in however many steps."""
    found, left = set[Node](), list(starts)
    while left:
        node = left.pop()
        if node not in found:
            found.add(node)
            left += following(node)
    return found


def turned(edges: Mapping[Node, Iterable[Node]]) -> dict[Node, list[Node]]:
    """Return the edges reversed."""
    back: dict[Node, list[Node]] = {node: [] for node in edges}
    for node, others in edges.items():
        for other in others:
            back.setdefault(other, []).append(node)
    return back


def _digraph(edges: Mapping[Node, Iterable[Node]]) -> "networkx.DiGraph[Node]":
    graph: networkx.DiGraph[Node] = networkx.DiGraph()
    graph.add_nodes_from(edges)
    graph.add_edges_from((node, other) for node, others in edges.items() for other in others)
    return graph
