"""Directed graphs of any nodes: order, loops, what hangs together, what is reached.

A graph is a mapping from each node to others: those that it needs, or those that it leads to. Nodes that are only
named among the others belong to it too. Each function takes time in proportion to nodes and edges, but for the heap
behind the alphabetical order.
"""

from collections.abc import Iterable, Iterator, Mapping
from heapq import heapify, heappop, heappush
from typing import Any, TypeVar

Node = TypeVar("Node", bound=Any)  # has a hash and an order


def strongly_connected(edges: Mapping[Node, Iterable[Node]]) -> Iterator[set[Node]]:
    """Sets of nodes that all reach each other (Tarjan, 1972); a node in no loop is a set of its own."""
    number: dict[Node, int] = {}  # of each node in the order in which it was found
    lowest: dict[Node, int] = {}  # lowest number that a node leads back to
    open_nodes, waiting = set[Node](), list[Node]()
    for root in edges:
        path = [] if root in number else [(root, iter(edges[root]))]
        while path:
            node, left = path[-1]
            if node not in number:
                number[node] = lowest[node] = len(number)
                open_nodes.add(node)
                waiting.append(node)
            for other in left:
                if other not in number:
                    path.append((other, iter(edges.get(other, ()))))
                    break
                if other in open_nodes:
                    lowest[node] = min(lowest[node], number[other])
            else:
                path.pop()
                if path:
                    lowest[path[-1][0]] = min(lowest[path[-1][0]], lowest[node])
                if lowest[node] == number[node]:
                    part = {waiting.pop()}
                    while node not in part:
                        part.add(waiting.pop())
                    open_nodes -= part
                    yield part


def loops(edges: Mapping[Node, Iterable[Node]]) -> list[set[Node]]:
    """Sets of nodes that all reach each other and themselves."""
    return [part for part in strongly_connected(edges) if len(part) > 1 or any(n in edges.get(n, ()) for n in part)]


def alphabetical(needs: Mapping[Node, Iterable[Node]]) -> Iterator[Node]:
    """The alphabetically first order in which each node comes after all that it needs (Kahn, 1962).

    Raises `ValueError` at a loop.
    """
    wanting: dict[Node, int] = {}
    followers: dict[Node, list[Node]] = {}
    for node, needed in needs.items():
        before = set(needed)
        wanting[node] = len(before)
        for other in before:
            followers.setdefault(other, []).append(node)
    wanting |= {node: 0 for node in followers if node not in wanting}
    ready = [node for node, count in wanting.items() if count == 0]
    heapify(ready)
    yielded = 0
    while ready:
        node = heappop(ready)
        for other in followers.get(node, ()):
            wanting[other] -= 1
            if wanting[other] == 0:
                heappush(ready, other)
        yielded += 1
        yield node
    if yielded < len(wanting):
        raise ValueError("a loop has no order")


def connected(nodes: Iterable[Node], edges: Iterable[tuple[Node, Node]]) -> list[set[Node]]:
    """Sets of nodes that hang together, whatever the direction of the edges, in the order of their first nodes."""
    both: dict[Node, list[Node]] = {node: [] for node in nodes}
    for first, second in edges:
        both.setdefault(first, []).append(second)
        both.setdefault(second, []).append(first)
    parts, known = list[set[Node]](), set[Node]()
    for node in both:
        if node not in known:
            parts.append({node} | reached(both, [node]))
            known |= parts[-1]
    return parts


def reached(edges: Mapping[Node, Iterable[Node]], starts: Iterable[Node]) -> set[Node]:
    """Return the nodes that can be reached from others. A start is among them only if a way leads back to it."""
    reachable, left = set[Node](), list(starts)
    while left:
        new = [other for other in edges.get(left.pop(), ()) if other not in reachable]
        reachable.update(new)
        left += new
    return reachable


def turned(edges: Mapping[Node, Iterable[Node]]) -> dict[Node, list[Node]]:
    """Return the edges reversed."""
    back: dict[Node, list[Node]] = {node: [] for node in edges}
    for node, others in edges.items():
        for other in others:
            back.setdefault(other, []).append(node)
    return back
