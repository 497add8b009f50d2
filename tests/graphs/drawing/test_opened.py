"""Opened subgraphs: what wires and probes outside reach, also where these are wrong or go deeper."""

from xml.etree import ElementTree

import pytest

from proofmass.blocks import Gain, Step
from proofmass.graphs.drawing.diagram import subgraph_paths, svg, with_tabs
from proofmass.graphs.drawing.picture import TAB, picture_of
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten


def opened(part: Graph, *wires: str, probe: str = "gain.output") -> tuple[list[str], list[tuple[str, str]]]:
    """The tabs and the probes of an opened part."""
    blocks = {"gain": Gain(), "part": part}
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=[probe])
    assert svg(graph, ["part"]).endswith("</svg>\n")
    flat = flatten(graph)
    picture = with_tabs(flat, part, picture_of(flat, part, "part."), "part.")
    return [name for name in picture.blocks if TAB in name], picture.probes


PART = Graph(name="", exports={"out": "a.output"}, blocks={"a": Step()})


def test_a_wire_of_a_right_graph_has_a_tab() -> None:
    assert opened(PART, "part.out -> gain.input")[0] == [f"out{TAB}"]
    assert opened(PART, "gain.output -> part.a.amplitude")[0] == [f"{TAB}a.amplitude"]


@pytest.mark.parametrize(
    "wire", ["part.nope -> gain.input", "part.a.nope -> gain.input", "part.b.output -> gain.input"]
)
def test_a_wire_to_what_is_not_there_has_none(wire: str) -> None:
    assert opened(PART, wire) == ([], [])


def test_a_probe_two_levels_down_is_at_the_export_of_the_part_between() -> None:
    inner = Graph(name="", exports={"input": "g.input", "out": "g.output"}, blocks={"g": Gain()})
    part = Graph(name="", blocks={"a": Step(), "b": inner}, wires=["a.output -> b.input"])
    tabs, probes = opened(part, "part.b.out -> gain.input", probe="part.b.g.output")
    assert tabs == [f"b.g.output{TAB}"]
    assert probes == [("b", "out")]


def test_a_wire_that_is_named_has_its_name_at_both_ends_but_where_it_comes_in() -> None:
    """The tab by which it comes into an opened part has its name already."""
    graph = read_graph("library:hemispherical_rebalance")
    root, space = ElementTree.fromstring(svg(graph, subgraph_paths(graph))), "{http://www.w3.org/2000/svg}"
    labels = {}
    for net in root.iterfind(f".//{space}g[@class='named']"):
        wires = [wire.get("data-wire") or "" for wire in net.iterfind(f"{space}g") if wire.get("data-wire")]
        labels[wires[0]] = len(list(net.iter(f"{space}text"))) - len(wires)
    assert labels["resonator.shell.→rotation.value → resonator.shell.shell.rotation"] == 0
    assert {more for wire, more in labels.items() if TAB not in wire.partition(" ")[0]} == {1}
