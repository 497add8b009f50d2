"""Order, loops and parts of directed graphs, beside networkx, which knows nothing of them."""

import networkx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.graphs.model.digraph import alphabetical, connected, loops, reached, strongly_connected, turned

Edges = dict[int, list[int]]
GRAPHS = st.dictionaries(st.integers(0, 12), st.lists(st.integers(0, 12), max_size=4), max_size=13)


def of_networkx(edges: Edges) -> "networkx.DiGraph[int]":
    graph: networkx.DiGraph[int] = networkx.DiGraph()
    graph.add_nodes_from(edges)
    graph.add_edges_from((node, other) for node, others in edges.items() for other in others)
    return graph


@given(GRAPHS)
def test_parts_are_those_of_networkx(edges: Edges) -> None:
    graph = of_networkx(edges)
    parts = sorted(map(sorted, strongly_connected(edges)))
    assert parts == sorted(map(sorted, networkx.strongly_connected_components(graph)))
    in_loops = {node for part in loops(edges) for node in part}
    assert in_loops == {node for cycle in networkx.simple_cycles(graph) for node in cycle}


@given(GRAPHS)
def test_the_order_is_that_of_networkx(needs: Edges) -> None:
    graph = of_networkx(needs).reverse()
    if not networkx.is_directed_acyclic_graph(graph):
        with pytest.raises(ValueError, match="a loop has no order"):
            list(alphabetical(needs))
        return
    assert list(alphabetical(needs)) == list(networkx.lexicographical_topological_sort(graph))


@given(GRAPHS, st.integers(0, 12))
def test_what_is_reached_and_what_hangs_together_is_as_networkx_says(edges: Edges, start: int) -> None:
    graph = of_networkx(edges)
    graph.add_node(start)
    assert reached(edges, [start]) - {start} == networkx.descendants(graph, start)
    assert reached(turned(edges), [start]) - {start} == networkx.ancestors(graph, start)
    assert (start in reached(edges, [start])) == any(start in cycle for cycle in networkx.simple_cycles(graph))
    pairs = [(node, other) for node, others in edges.items() for other in others]
    parts = sorted(map(sorted, connected([start, *edges], pairs)))
    assert parts == sorted(map(sorted, networkx.connected_components(graph.to_undirected())))


def test_a_long_chain_is_no_deep_call() -> None:
    chain = {node: [node + 1] for node in range(100_000)}
    assert list(alphabetical(turned(chain)))[:3] == [0, 1, 2]
    assert sum(1 for _ in strongly_connected(chain)) == 100_001
    assert len(loops(chain | {100_000: [0]})[0]) == 100_001
