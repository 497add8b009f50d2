"""Layers of a diagram, counted by hand."""

from itertools import pairwise

from proofmass.graphs.drawing.layers import Link, assign_layers


def links(*ways: str) -> list[Link]:
    """Wires as in `a b !c`, each block to the next; a mark stands before one of which a parameter is driven."""
    found = []
    for way in ways:
        names = way.split()
        for source, target in pairwise(names):
            found.append(Link(source.strip("!"), "output", target.strip("!"), "input", target.startswith("!")))
    return found


def layers(*ways: str) -> dict[str, int]:
    wires = links(*ways)
    return dict(assign_layers({name for wire in wires for name in (wire.source, wire.target)}, wires).of)


def test_a_block_with_more_readers_than_inputs_stands_before_the_first_of_them() -> None:
    """The source s moves from the first layer; t, with one wire on either side, stays where its input lets it."""
    assert layers("a b c d", "s c", "s d", "a t d") == {"a": 0, "b": 1, "c": 2, "d": 3, "s": 1, "t": 1}


def test_a_loop_begins_where_the_fewest_of_its_own_wires_lead_back() -> None:
    """A wire that drives a parameter counts half; those from outside the loop, of which q has two, do not count."""
    found = layers("q p z", "p !q", "e q", "f q", "g p")
    assert found == {"e": 0, "f": 0, "q": 1, "g": 1, "p": 2, "z": 3}
