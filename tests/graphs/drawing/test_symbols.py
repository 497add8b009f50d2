"""Diagrams: symbols, marks, hops, nets that drive parameters, opened subgraphs and overlays."""

import re
from itertools import pairwise
from xml.etree import ElementTree

import pytest

from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Difference,
    DigitalToAnalog,
    FlexurePendulum,
    Gain,
    Negation,
    Product,
    Ramp,
    Sum,
)
from proofmass.graphs.drawing.diagram import subgraph_paths, svg
from proofmass.graphs.drawing.looks import _along
from proofmass.graphs.drawing.texts import width_of
from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from tests.by_hand.diagrams import GRAPHS, SVG, accelerometer, box_of, drawn, edges, straight, words_of


def test_marks_of_probes_units_rates_driven_parameters_and_continuous_blocks() -> None:
    graph = Graph(
        name="marks",
        rate="50 kHz",
        blocks={"dac": DigitalToAnalog(), "plain": Constant(), "pendulum": FlexurePendulum(), "drift": Ramp(unit="V")},
        wires=["plain.output -> dac.number", "drift.output -> dac.reference"],
        probes=["dac.code", "pendulum.angular_velocity"],
        rates={"dac": "9600/1023 Hz"},
    )
    text = svg(graph)
    root = ElementTree.fromstring(text)
    groups = {group.attrib["data-block"]: group for group in root.iter(f"{SVG}g") if "data-block" in group.attrib}
    words = {name: list(words_of(group)) for name, group in groups.items()}
    marks = {name: [p.attrib["class"] for p in group.iter(f"{SVG}path")] for name, group in groups.items()}
    assert words["dac"] == ["dac", "DigitalToAnalog", "number", "code", "voltage", "reference"]
    assert [t.text for t in groups["dac"].iter(f"{SVG}tspan")] == ["3200/341 Hz"]
    assert words["pendulum"][-1] == "rad/s"
    assert marks == {"dac": ["probe"], "pendulum": ["probe"], "plain": [], "drift": []}
    assert [name for name, group in groups.items() if "continuous" in group.attrib["class"]] == ["pendulum"]
    wires = {group.attrib["data-wire"]: group for group in root.iter(f"{SVG}g") if "data-wire" in group.attrib}
    assert wires["drift.output → dac.reference"].attrib["class"].startswith("wire driven net0")
    assert wires["plain.output → dac.number"].attrib["class"].startswith("wire format")
    assert "reference: driven by drift.output" in text
    assert "bits = 20 bit" in text
    assert "prefers-color-scheme:dark" in text


def test_symbols_show_signs_and_gains() -> None:
    graph = Graph(
        name="",
        rate=1,
        blocks={
            "push": Constant(),
            "sum": Sum(),
            "less": Difference(),
            "times": Product(),
            "gain": Gain(gain=2.5, output_unit="V"),
            "turn": Negation(),
        },
        wires=[
            f"push.output -> {end}"
            for end in (
                "sum.first",
                "sum.second",
                "sum.fourth",
                "less.first",
                "less.second",
                "times.first",
                "times.second",
                "gain.input",
                "turn.input",
            )
        ],
    )
    root = ElementTree.fromstring(svg(graph))
    groups = {group.attrib["data-block"]: group for group in root.iter(f"{SVG}g") if "data-block" in group.attrib}
    words = {name: list(words_of(group)) for name, group in groups.items()}
    assert words["sum"] == ["+", "+", "+", "sum"]
    assert words["less"] == ["+", "−", "less"]
    assert words["times"] == ["×", "×", "times"]
    assert words["gain"][:2] == ["gain", "2.5 V"]
    assert words["turn"] == ["−1", "turn"]
    assert edges(graph)["sum"][2] - edges(graph)["sum"][0] == 40.0


def test_a_value_and_a_rate_stand_below_their_symbol() -> None:
    """Lines of a type of 11 pixels, the first one below the symbol, and the last one within the room of the block."""
    graph = Graph(
        name="",
        rate="10 kHz",
        blocks={"push": Constant(), "sum": Sum(), "gain": Gain(gain=2.5)},
        wires=["push.output -> sum.first", "push.output -> sum.second", "sum.output -> gain.input"],
        rates={"sum": "5 kHz", "gain": "5 kHz"},
    )
    groups = [group for group in ElementTree.fromstring(svg(graph)).iter(f"{SVG}g") if "data-block" in group.attrib]
    lines = {"sum": ["5 kHz"], "gain": ["2.5", "5 kHz"]}
    for name, group in {group.attrib["data-block"]: group for group in groups}.items():
        below = [text for text in group.iter(f"{SVG}text") if text.attrib["class"] in ("setting", "rate")]
        assert [text.text for text in below] == lines.get(name, [])
        if below:
            heights = [float(text.attrib["y"]) for text in below]
            area = next(rect for rect in group.iter(f"{SVG}rect") if rect.attrib["class"] == "area")
            assert heights[0] - 11.0 >= edges(graph)[name][3]
            assert heights[-1] <= float(area.attrib["y"]) + float(area.attrib["height"])
            assert all(second - first >= 11.0 for first, second in pairwise(heights))


def test_names_of_driven_parameters_stand_side_by_side() -> None:
    """At least 10 pixels apart, also from both sides of the block, and no more than the grid of 20 asks for."""
    names = ["reference", "offset_error", "gain"]
    across, places = _along(names, {"gain": (0, 60)})
    widths = [width_of("reference", 11, bold=True), width_of("offset_error", 11, bold=True), 60]
    spans = [(places[name] - width / 2, places[name] + width / 2) for name, width in zip(names, widths, strict=True)]
    gaps = [after - before for before, after in pairwise([0, *(end for span in spans for end in span), across + 10])]
    assert all(10 <= gap < 30 for gap in gaps[::2])


@pytest.mark.exhaustive(but=12)
@pytest.mark.exhaustive("random 2_0")
@pytest.mark.parametrize("graph", GRAPHS[2:40], ids=lambda graph: graph.name)
def test_level_wires_hop_over_every_upright_wire_that_they_cross(graph: Graph) -> None:
    """A bow wherever lines of two outputs cross, as the corners of the wires say, unless a corner is too near."""
    _, wires = drawn(graph)
    lines = {(piece, wire.split(" → ")[0]) for wire, segments in wires.items() for piece in straight(segments)}
    level = [(a, b, net) for (a, b), net in lines if a[1] == b[1]]
    upright = [(a, b, net) for (a, b), net in lines if a[0] == b[0]]
    crossings = {
        (x, y)
        for (x1, y), (x2, _), net in level
        for (x, y1), (_, y2), other in upright
        if net != other and min(x1, x2) + 4 <= x <= max(x1, x2) - 4 and min(y1, y2) < y < max(y1, y2)
    }
    bows = re.findall(r"L(-?[\d.]+) (-?[\d.]+)a4 4 0 0 [01] (-?8) 0", svg(graph))
    assert {(float(x) + float(way) / 2, float(y)) for x, y, way in bows} == crossings


def test_nets_that_drive_parameters_are_told_apart() -> None:
    graph = Graph(
        name="",
        rate=1,
        blocks={"a": Constant(), "b": Constant(), "adc": AnalogToDigital(), "source": Constant()},
        wires=["a.output -> adc.reference", "b.output -> adc.offset_error", "source.output -> adc.voltage"],
    )
    text = svg(graph)
    classes = re.findall(r'class="(wire driven net\d)', text)
    assert sorted(classes) == ["wire driven net0", "wire driven net1"]
    dashes = re.findall(r"\.net[01] \.line\{stroke:#\w+;stroke:var\(--c\d\);stroke-dasharray:([\d .]+)\}", text)
    assert len(set(dashes)) == 2
    assert re.search(r'class="port net0"[^>]*>reference<', text)
    assert re.search(r'class="port net1"[^>]*>offset_error<', text)


def test_a_subgraph_says_its_file_and_unfolds_in_its_place() -> None:
    graph = read_graph(library_files()["closed_loop_gyroscope.toml"])
    folded, unfolded = svg(graph), svg(graph, ["drive"])
    assert subgraph_paths(graph) == ["drive"]
    assert ">resonator_loop.toml</text>" in folded
    inner = [f"drive.{name}" for name in graph.subgraphs["drive"].blocks]
    blocks = [set(re.findall(r'data-block="([^"]+)"', text)) for text in (folded, unfolded)]
    assert blocks[1] - blocks[0] == set(inner)
    assert re.findall(r'data-signal="(drive\.oscillator\.sine)"', folded)  # an export says what it is inside
    root = ElementTree.fromstring(unfolded)
    (opened,) = (group for group in root.iter(f"{SVG}g") if group.attrib.get("data-block") == "drive")
    frame = opened.find(f"{SVG}rect")
    assert frame is not None
    (inside,) = (group for group in opened if "transform" in group.attrib and group.attrib.get("class") != "fold")
    x, y = (float(n) for n in re.findall(r"[\d.]+", inside.attrib["transform"]))
    right, bottom = (float(frame.attrib[a]) + float(frame.attrib[b]) for a, b in (("x", "width"), ("y", "height")))
    for rect in inside.iter(f"{SVG}rect"):
        if rect.attrib["class"] in ("box", "area"):
            assert float(frame.attrib["x"]) < float(rect.attrib["x"]) + x
            assert float(rect.attrib["x"]) + float(rect.attrib["width"]) + x < right
            assert float(rect.attrib["y"]) + float(rect.attrib["height"]) + y < bottom


def test_words_of_a_legend_stand_beside_their_marks() -> None:
    marks = [group for group in ElementTree.fromstring(svg(accelerometer())).iter(f"{SVG}g") if len(group) == 2]
    marks = [mark for mark in marks if mark.get("transform") and mark[1].tag == f"{SVG}text"]
    assert len(marks) == 3 + 2 + 1 + 2
    for mark, words in marks:
        drawn_as = mark.attrib["d"] if "d" in mark.attrib else "".join(map(_outline, mark))
        assert 0.0 < float(words.attrib["x"]) - box_of(drawn_as)[2] <= 12.0, words.text


def _outline(part: ElementTree.Element) -> str:
    return part.get("d") or f"M0 0H{part.attrib['width']}"


def test_overlays_colour_rates_loops_and_formats() -> None:
    graph = read_graph(library_files()["fixed_against_floating.toml"])
    text = svg(graph, ["part"] if "part" in graph.subgraphs else subgraph_paths(graph), overlay="formats")
    assert 'class="proofmass formats"' in text
    formats = {str(port) for port in re.findall(r">(\(\d+, -?\d+\))<", text)}
    assert formats
    gyroscope = svg(read_graph(library_files()["closed_loop_gyroscope.toml"]), overlay="rates")
    legend = gyroscope.partition('class="legend only rates"')[2].partition("legend only loops")[0]
    assert [rate for rate in ("8 kHz", "128 kHz", "continuous") if f">{rate}</text>" in legend] == [
        "8 kHz",
        "128 kHz",
        "continuous",
    ]
    loop = svg(accelerometer(), overlay="loops")
    members = {
        name for about, name in re.findall(r'<g class="([^"]*)" data-block="([^"]+)"', loop) if "loop0" in about.split()
    }
    assert members == {"torque", "pendulum", "pickoff", "adc", "minus", "pid", "dac", "resistor", "torquer"}
