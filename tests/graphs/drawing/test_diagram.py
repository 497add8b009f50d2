"""Diagrams: everything is there, nothing overlaps, and the order of declaration changes nothing."""

import random
import re
from html import escape
from itertools import combinations, pairwise
from xml.etree import ElementTree

import pytest

from proofmass.blocks import (
    Constant,
    Gain,
    MassSpringDamper,
    Step,
    Sum,
)
from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.drawing.text_forms import dot, mermaid
from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from tests.by_hand.diagrams import (
    GRAPHS,
    SVG,
    accelerometer,
    chain,
    drawn,
    edges,
    random_graph,
    within,
)

RUNNABLE = [
    name for name, path in library_files().items() if path.suffix == ".toml" and "[blocks" in path.read_text("utf-8")
]


@pytest.mark.exhaustive(but=20)
@pytest.mark.exhaustive("random 2_0")
@pytest.mark.parametrize("graph", GRAPHS, ids=lambda graph: graph.name)
@pytest.mark.friendly(15, "everything is drawn and nothing overlaps")
def test_every_block_and_every_wire_is_drawn_and_nothing_overlaps(graph: Graph) -> None:
    boxes, wires = drawn(graph)
    symbols = edges(graph)
    assert sorted(boxes) == sorted(graph.blocks)
    assert sorted(wires) == sorted(f"{wire.source} → {wire.target}" for wire in graph.wires)
    for (_, first), (_, second) in combinations(boxes.items(), 2):
        apart = first[2] < second[0] or second[2] < first[0] or first[3] < second[1] or second[3] < first[1]
        assert apart, (first, second)
    for wire, segments in wires.items():
        for segment in segments:
            assert segment[0][0] == segment[1][0] or segment[0][1] == segment[1][1], (wire, segment)
            for name, box in boxes.items():
                ends = name in (wire.split(".")[0], wire.split(" → ")[1].split(".")[0])
                assert not within(segment, symbols[name] if ends else box, -3 if ends else 5), (wire, segment, name)


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda graph: graph.name)
def test_wires_start_and_end_at_their_blocks(graph: Graph) -> None:
    boxes = edges(graph)
    _, wires = drawn(graph)
    for wire, segments in wires.items():
        source, target = wire.split(" → ")
        (x, y), (to_x, to_y) = segments[0][0], segments[-1][1]
        left, top, right, bottom = boxes[source.split(".")[0]]
        assert x in (left, right)
        assert top < y < bottom
        name, port = target.split(".")
        left, top, right, bottom = boxes[name]
        if port in type(graph.blocks[name]).inputs:
            assert min(to_x - left, right - to_x) in (0, pytest.approx(2.7))  # a circle is met within its height
            assert top < to_y < bottom
        else:
            assert left < to_x < right
            assert to_y == bottom


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda graph: graph.name)
def test_wires_from_different_outputs_share_no_line(graph: Graph) -> None:
    _, wires = drawn(graph)
    lines: dict[tuple[bool, float], list[tuple[float, float, str]]] = {}
    for wire, segments in wires.items():
        for (x1, y1), (x2, y2) in segments:
            upright = x1 == x2
            along = sorted((y1, y2) if upright else (x1, x2))
            lines.setdefault((upright, x1 if upright else y1), []).append((along[0], along[1], wire.split(" → ")[0]))
    for pieces in lines.values():
        for (low, high, source), (other_low, other_high, other) in combinations(pieces, 2):
            assert source == other or high < other_low or other_high < low, (source, other)


@pytest.mark.exhaustive("2", "4")
@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_declaration_changes_nothing(seed: int) -> None:
    graph = accelerometer() if seed == 0 else random_graph(seed, 30)
    draw = random.Random(seed)
    blocks, wires, probes = list(graph.blocks.items()), list(graph.wires), list(graph.probes)
    for part in (blocks, wires, probes):
        draw.shuffle(part)
    other = Graph(
        name=graph.name, rate=graph.rate, blocks=dict(blocks), wires=wires, probes=probes, loops=dict(graph.loops)
    )
    assert (svg(other), mermaid(other), dot(other)) == (svg(graph), mermaid(graph), dot(graph))


def test_a_chain_is_drawn_in_one_straight_line() -> None:
    _, wires = drawn(chain(6))
    assert [len(segments) for segments in wires.values()] == [1] * 5


def test_the_return_path_of_a_loop_runs_back_below_it() -> None:
    forward, back = ["sum", "a", "b", "c", "d"], ["e", "f"]
    way = pairwise([*forward, *back])
    graph = Graph(
        name="loop",
        rate=1,
        blocks={"push": Constant(), "sum": Sum()} | {name: Gain() for name in (*forward[1:], *back)},
        wires=["push.output -> sum.first", "f.output -> sum.second"]
        + [f"{a}.output -> {b}.{'first' if b == 'sum' else 'input'}" for a, b in way],
        probes=["d.output"],
    )
    boxes, wires = drawn(graph)
    assert all(boxes[a][2] < boxes[b][0] for a, b in pairwise(forward))
    assert boxes["f"][2] < boxes["e"][0]
    assert min(boxes[name][1] for name in back) > max(boxes[name][3] for name in forward)
    (start, _), *_ = wires["f.output → sum.second"]
    assert start[0] == edges(graph)["f"][0]


def test_units_are_written_as_by_hand() -> None:
    gain = Gain(input_unit="1", output_unit="kg*m^2/s^3/A", gain=1.0)
    assert ">kg·m²/s³/A</text>" in svg(Graph(name="", blocks={"gain": gain}, probes=["gain.output"]))


@pytest.mark.friendly(13, "diagrams and their tooltips have what was written")
def test_a_block_and_its_tooltip_have_quantities_as_they_were_written() -> None:
    blocks = {
        "step": Step(amplitude="1 g0", unit="m/s^2"),
        "mass": MassSpringDamper(mass="20 ug", damping="0.000050 kg/s"),
    }
    drawn_as = svg(Graph(name="", blocks=blocks, probes=["mass.displacement"]))
    assert ">amplitude 1 g0</text>" in drawn_as
    assert ">mass 20 µg</text>" in drawn_as
    assert "amplitude = 1 g0\n" in drawn_as
    assert "mass = 20 µg\ndamping = 0.000050 kg/s\n" in drawn_as
    assert "9.80665" not in drawn_as


def test_a_wire_with_several_targets_branches_with_dots_and_draws_no_line_twice() -> None:
    graph = next(graph for graph in GRAPHS if graph.name == "fan-out")
    root = ElementTree.fromstring(svg(graph))
    assert len([c for c in root.iter(f"{SVG}circle") if c.attrib["class"] == "dot"]) == 5
    wires = [group for group in root.iter(f"{SVG}g") if "data-wire" in group.attrib]
    lines = [path.attrib["d"] for wire in wires for path in wire if path.attrib.get("class") == "line"]
    starts = [line.split("L")[0] for line in lines]
    assert len(lines) == 7
    assert len(set(lines)) == 7
    assert starts.count(starts[0]) == 1


def test_text_is_escaped_and_what_xml_cannot_hold_is_replaced() -> None:
    name = 'a < b & "c" \ufffe'
    root = ElementTree.fromstring(svg(Graph(name=name, blocks={"gain": Gain()})))
    title = next(text for text in root.iter(f"{SVG}text") if text.attrib.get("class") == "title")
    assert title.text == 'a < b & "c" \ufffd'
    assert escape("a < b") in svg(Graph(name=name, blocks={}))
    assert dot(Graph(name='say "no"\\', blocks={})).startswith('digraph "say \\"no\\"\\\\" {')


def test_wires_whose_ends_do_not_exist_are_left_out() -> None:
    wires = ["gain.output -> nowhere.input", "gain.none -> gain.input", "gain.output -> gain.none"]
    graph = Graph(name="", blocks={"gain": Gain()}, wires=wires, probes=["gain.none", "nobody.output"])
    assert drawn(graph)[1] == {}
    assert "-->" not in mermaid(graph)
    assert "->" not in dot(graph)


def test_an_input_driven_twice_is_drawn_as_declared() -> None:
    graph = Graph(
        name="",
        blocks={"a": Constant(), "b": Constant(), "gain": Gain()},
        wires=["a.output -> gain.input", "b.output -> gain.input"],
    )
    assert sorted(drawn(graph)[1]) == ["a.output → gain.input", "b.output → gain.input"]


@pytest.mark.exhaustive
def test_a_long_chain_and_a_long_loop_are_drawn() -> None:
    graph = chain(1500)
    loop = Graph(name="loop", rate=1, blocks=graph.blocks, wires=[*graph.wires, "g1499.output -> g0.input"])
    assert len(drawn(graph)[1]) == 1499
    assert len(drawn(loop)[1]) == 1500


def test_what_nothing_joins_stands_side_by_side() -> None:
    boxes, _ = drawn(Graph(name="", rate=1, blocks={**chain(3).blocks, "wide": Sum()}))
    assert max(top for _, top, _, _ in boxes.values()) < min(bottom for *_, bottom in boxes.values())


@pytest.mark.exhaustive(but=35)
@pytest.mark.exhaustive("quartz_recalibration.toml")
@pytest.mark.parametrize("name", RUNNABLE)
@pytest.mark.friendly(15, "graphs of the library fit a page")
def test_diagrams_of_the_library_fit_a_page(name: str) -> None:
    """A page of 1,400 pixels shows all of the width, or nearly, of what is high too; no text is below ten pixels."""
    text = svg(read_graph(library_files()[name]))
    width, height = (int(number) for number in re.findall(r' (?:width|height)="(\d+)"', text)[:2])
    assert width <= 1340 or (width <= 1400 and width < 1.25 * height)
    sizes = [float(size) for size in re.findall(r"font(?:-size)?:(?:bold )?([\d.]+)px", text)]
    assert min(sizes) >= 10.0


@pytest.mark.parametrize("length", [9, 40, 200])
def test_a_chain_that_is_too_long_goes_on_in_the_next_row(length: int) -> None:
    boxes, wires = drawn(chain(length))
    rows = sorted({box[1] for box in boxes.values()})
    across, down = max(box[2] for box in boxes.values()), max(box[3] for box in boxes.values())
    assert len(rows) > 1 or across <= 1400
    assert across < max(1400.0, 2.0 * down)
    places = [(boxes[f"g{i}"][1], boxes[f"g{i}"][0]) for i in range(length)]
    assert places == sorted(places)  # as words are read
    assert len(wires) == length - 1
