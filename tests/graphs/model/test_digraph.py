"""Order, loops and parts of directed graphs, against searches of every path by hand."""

import itertools

import networkx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.graphs.model.digraph import alphabetical, connected, loops, reached, turned

Edges = dict[int, list[int]]
GRAPHS = st.dictionaries(st.integers(0, 12), st.lists(st.integers(0, 12), max_size=4), max_size=13)


def ways(edges: Edges) -> dict[int, set[int]]:
    """Nodes at the end of a way of one edge or more, by Warshall's closure."""
    nodes = {*edges, *itertools.chain(*edges.values())}
    ends = {node: set(edges.get(node, ())) for node in nodes}
    for middle, start in itertools.product(nodes, nodes):
        if middle in ends[start]:
            ends[start] |= ends[middle]
    return ends


@given(GRAPHS)
def test_loops_are_nodes_that_reach_each_other(edges: Edges) -> None:
    ends = ways(edges)
    expected = {frozenset(n for n in ends[node] if node in ends[n]) for node in ends if node in ends[node]}
    assert set(map(frozenset, loops(edges))) == expected
    assert len(loops(edges)) == len(expected)


@given(GRAPHS)
def test_each_node_comes_after_what_it_needs_and_else_as_early_as_the_alphabet_lets_it(needs: Edges) -> None:
    ends = ways(needs)
    if any(node in ends[node] for node in ends):
        with pytest.raises(networkx.NetworkXUnfeasible):
            list(alphabetical(needs))
        return
    left, expected = set(ends), list[int]()
    while left:
        expected.append(min(node for node in left if not left & set(needs.get(node, ()))))
        left.remove(expected[-1])
    assert list(alphabetical(needs)) == expected


@given(GRAPHS, st.sets(st.integers(0, 12)))
def test_ways_lead_forwards_and_backwards(edges: Edges, starts: set[int]) -> None:
    ends = ways(edges)
    assert reached(edges, starts) == set().union(*(ends.get(start, set()) for start in starts))
    assert reached(turned(edges), starts) == {node for node in ends if ends[node] & starts}


@given(GRAPHS)
def test_parts_hang_together(edges: Edges) -> None:
    pairs = [(node, other) for node, others in edges.items() for other in others]
    ends = ways(
        {node: [*others, *turned(edges).get(node, ())] for node, others in edges.items()}
        | {other: [*edges.get(other, ()), *turned(edges)[other]] for _, other in pairs}
    )
    parts = connected(edges, pairs)
    assert {frozenset(part) for part in parts} == {frozenset({node} | ends[node]) for node in ends}
    firsts = [next(node for node in [*edges, *ends] if node in part) for part in parts]
    assert firsts == sorted(firsts, key=[*edges, *ends].index)


@pytest.mark.exhaustive
def test_a_long_chain_is_no_deep_call() -> None:
    chain = {node: [node + 1] for node in range(30_000)}
    assert list(alphabetical(turned(chain)))[:3] == [0, 1, 2]
    assert len(loops(chain | {30_000: [0]})[0]) == 30_001
