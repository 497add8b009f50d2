"""Diagrams: everything is there, nothing overlaps, and the order of declaration changes nothing."""

import random
import re
from collections.abc import Iterator
from html import escape
from itertools import combinations, pairwise
from xml.etree import ElementTree

import pytest

from proofmass.blocks import AnalogToDigital, Constant, DigitalToAnalog, FlexurePendulum, Gain, Negation, Ramp, Sum
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.drawing.diagram import dot, mermaid, svg
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph

Box = tuple[float, float, float, float]  # left, top, right, bottom
Segment = tuple[tuple[float, float], tuple[float, float]]
SVG = "{http://www.w3.org/2000/svg}"
KINDS: list[type[Block]] = [Gain, Sum, DigitalToAnalog, Constant, FlexurePendulum, Negation, AnalogToDigital]


def random_graph(seed: int, size: int = 0) -> Graph:
    """Blocks wired at random, mostly from left to right, whatever the units; the diagram does not ask for them."""
    draw = random.Random(seed)
    names = [f"b{i}" for i in range(size or draw.randrange(1, 25))]
    blocks = {name: draw.choice(KINDS)() for name in names}
    signals = [f"{name}.{port}" for name in names for port in type(blocks[name]).outputs]
    backward = draw.random() ** 2
    wires = []
    for i, name in enumerate(names):
        targets = [port for port in type(blocks[name]).inputs if draw.random() < 0.9]
        targets += ["reference", "offset_error"] if draw.random() < 0.5 else []
        for port in targets:
            if port in type(blocks[name]).inputs or port in type(blocks[name]).parameters:
                earlier = [s for s in signals if int(s[1 : s.index(".")]) < i]
                wires.append(
                    f"{draw.choice(signals if draw.random() < backward or not earlier else earlier)} -> {name}.{port}"
                )
    probes = draw.sample(signals, draw.randrange(min(3, len(signals))))
    return Graph(name=f"random {seed}", rate="10 kHz", blocks=blocks, wires=wires, probes=probes)


def chain(length: int) -> Graph:
    wires = [f"g{i}.output -> g{i + 1}.input" for i in range(length - 1)]
    return Graph(name="chain", rate="1 kHz", blocks={f"g{i}": Gain() for i in range(length)}, wires=wires)


def accelerometer() -> Graph:
    return read_graph(library_file("closed_loop_accelerometer.toml"))


def example_graphs() -> Iterator[Graph]:
    yield accelerometer()
    yield chain(6)
    yield Graph(name="none", blocks={})
    yield Graph(
        name="fan-out",
        rate=1,
        blocks={"source": Constant()} | {f"g{i}": Gain() for i in range(7)},
        wires=[f"source.output -> g{i}.input" for i in range(7)],
    )
    yield Graph(
        name="loops of one block",
        rate=1,
        blocks={"alone": Gain(), "dac": DigitalToAnalog(), "sum": Sum()},
        wires=["sum.output -> sum.first", "dac.voltage -> dac.number", "dac.voltage -> dac.reference"],
    )
    yield Graph(  # wires that swap sides between two layers need a way round each other
        name="crossed",
        rate=1,
        blocks={"a": Constant(), "b": Constant(), "x": Sum(), "y": Sum(), "z": Sum()},
        wires=[f"{s}.output -> {t}.{p}" for t in "xyz" for s, p in (("b", "first"), ("a", "second"), ("b", "third"))],
    )
    yield random_graph(1, 40)
    yield random_graph(2, 90)


GRAPHS = [*example_graphs(), *(random_graph(seed) for seed in range(60))]


def drawn(graph: Graph) -> tuple[dict[str, Box], dict[str, list[Segment]]]:
    """Boxes of the blocks and segments of the wires, read back from the picture."""
    root = ElementTree.fromstring(svg(graph))
    boxes: dict[str, Box] = {}
    wires: dict[str, list[Segment]] = {}
    for group in root.iter(f"{SVG}g"):
        if "data-block" in group.attrib:
            rect = group.find(f"{SVG}rect")
            assert rect is not None
            x, y, width, height = (float(rect.attrib[name]) for name in ("x", "y", "width", "height"))
            boxes[group.attrib["data-block"]] = (x, y, x + width, y + height)
        if "data-wire" in group.attrib:
            reach = next(path for path in group.iter(f"{SVG}path") if path.attrib["class"] == "reach")
            numbers = [float(n) for n in re.findall(r"-?[\d.]+", reach.attrib["d"])]
            points = list(zip(numbers[::2], numbers[1::2], strict=True))
            wires[group.attrib["data-wire"]] = [(a, b) for a, b in pairwise(points) if a != b]
    return boxes, wires


def within(segment: Segment, box: Box, margin: float) -> bool:
    """Whether some of the segment lies inside the box grown by the margin."""
    (x1, x2), (y1, y2) = (sorted(ends) for ends in zip(*segment, strict=True))
    left, top, right, bottom = box
    return x2 > left - margin and x1 < right + margin and y2 > top - margin and y1 < bottom + margin


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda graph: graph.name)
def test_every_block_and_every_wire_is_drawn_and_nothing_overlaps(graph: Graph) -> None:
    boxes, wires = drawn(graph)
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
                assert not within(segment, box, 0 if ends else 5), (wire, segment, name)


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda graph: graph.name)
def test_wires_start_and_end_at_their_blocks(graph: Graph) -> None:
    boxes, wires = drawn(graph)
    for wire, segments in wires.items():
        source, target = wire.split(" → ")
        (x, y), (to_x, to_y) = segments[0][0], segments[-1][1]
        left, top, right, bottom = boxes[source.split(".")[0]]
        assert x in (left, right)
        assert top < y < bottom
        name, port = target.split(".")
        left, top, right, bottom = boxes[name]
        if port in type(graph.blocks[name]).inputs:
            assert to_x in (left, right)
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


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_declaration_changes_nothing(seed: int) -> None:
    graph = accelerometer() if seed == 0 else random_graph(seed, 30)
    draw = random.Random(seed)
    blocks, wires, probes = list(graph.blocks.items()), list(graph.wires), list(graph.probes)
    for part in (blocks, wires, probes):
        draw.shuffle(part)
    other = Graph(name=graph.name, rate=graph.rate, blocks=dict(blocks), wires=wires, probes=probes)
    assert (svg(other), mermaid(other), dot(other)) == (svg(graph), mermaid(graph), dot(graph))


def test_a_chain_is_drawn_in_one_straight_line() -> None:
    _, wires = drawn(chain(6))
    assert [len(segments) for segments in wires.values()] == [1] * 5


def test_the_return_path_of_a_loop_runs_back_below_it() -> None:
    boxes, wires = drawn(accelerometer())
    assert boxes["torquer"][2] < boxes["resistor"][0] < boxes["dac"][2]
    assert boxes["torquer"][1] > boxes["pid"][3]
    assert boxes["resistor"][1] > boxes["dac"][3]
    (start, _), *_ = wires["torquer.output → torque.second"]
    assert start[0] == boxes["torquer"][0]
    forward = ["acceleration", "pendulosity", "torque", "pendulum", "pickoff", "adc", "minus", "pid", "dac"]
    assert all(boxes[a][2] < boxes[b][0] for a, b in pairwise(forward))


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
    words = {name: [t.text for t in group.iter(f"{SVG}text")] for name, group in groups.items()}
    marks = {name: [p.attrib["class"] for p in group.iter(f"{SVG}path")] for name, group in groups.items()}
    assert words["dac"] == ["dac", "DigitalToAnalog", "number", "code", "voltage", "reference"]
    assert [t.text for t in groups["dac"].iter(f"{SVG}tspan")] == ["3200/341 Hz"]
    assert words["pendulum"][-1] == "rad/s"
    assert marks == {"dac": ["probe"], "pendulum": ["probe"], "plain": [], "drift": []}
    assert [name for name, group in groups.items() if "continuous" in group.attrib["class"]] == ["pendulum"]
    wires = {group.attrib["data-wire"]: group for group in root.iter(f"{SVG}g") if "data-wire" in group.attrib}
    assert wires["drift.output → dac.reference"].attrib["class"] == "wire driven"
    assert wires["plain.output → dac.number"].attrib["class"] == "wire"
    assert "reference: driven by drift.output" in text
    assert "bits = 20 bit" in text
    assert "prefers-color-scheme:dark" in text


def test_units_are_written_as_by_hand() -> None:
    gain = Gain(input_unit="1", output_unit="kg*m^2/s^3/A", gain=1.0)
    assert ">kg·m²/s³/A</text>" in svg(Graph(name="", blocks={"gain": gain}, probes=["gain.output"]))


def test_a_wire_with_several_targets_branches_with_dots_and_draws_no_line_twice() -> None:
    graph = next(graph for graph in GRAPHS if graph.name == "fan-out")
    root = ElementTree.fromstring(svg(graph))
    assert len([c for c in root.iter(f"{SVG}circle") if c.attrib["class"] == "dot"]) == 5
    lines = [path.attrib["d"] for path in root.iter(f"{SVG}path") if path.attrib["class"] == "line"]
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


def test_a_long_chain_and_a_long_loop_are_drawn() -> None:
    graph = chain(1500)
    loop = Graph(name="loop", rate=1, blocks=graph.blocks, wires=[*graph.wires, "g1499.output -> g0.input"])
    assert len(drawn(graph)[1]) == 1499
    assert len(drawn(loop)[1]) == 1500


def small() -> Graph:
    return Graph(
        name="small",
        rate="1 kHz",
        blocks={"end": DigitalToAnalog(), "pendulum": FlexurePendulum(), "ramp": Ramp(unit="V"), "source": Constant()},
        wires=["ramp.output -> end.reference", "source.output -> end.number", "source.output -> pendulum.torque"],
        probes=["pendulum.angle"],
        rates={"end": "250 Hz"},
    )


def test_mermaid_text() -> None:
    assert mermaid(small()) == (
        "flowchart LR\n"
        '    block_end["end<br/>DigitalToAnalog<br/>250 Hz"]\n'
        '    block_pendulum("pendulum<br/>FlexurePendulum")\n'
        '    block_ramp["ramp<br/>Ramp"]\n'
        '    block_source["source<br/>Constant"]\n'
        '    block_ramp -.->|"output → reference [V]"| block_end\n'
        '    block_source -->|"output → number"| block_end\n'
        '    block_source -->|"output → torque"| block_pendulum\n'
        '    probe_0>"pendulum.angle"]\n'
        "    block_pendulum --o probe_0\n"
    )


def test_dot_text() -> None:
    assert dot(small()) == (
        'digraph "small" {\n'
        "    rankdir=LR\n"
        "    node [shape=box]\n"
        '    "end" [label="end\\nDigitalToAnalog\\n250 Hz"]\n'
        '    "pendulum" [label="pendulum\\nFlexurePendulum", style=rounded]\n'
        '    "ramp" [label="ramp\\nRamp"]\n'
        '    "source" [label="source\\nConstant"]\n'
        '    "ramp" -> "end" [label="output → reference [V]", style=dashed]\n'
        '    "source" -> "end" [label="output → number"]\n'
        '    "source" -> "pendulum" [label="output → torque"]\n'
        '    "pendulum.angle" [shape=cds]\n'
        '    "pendulum" -> "pendulum.angle" [arrowhead=none]\n'
        "}\n"
    )
