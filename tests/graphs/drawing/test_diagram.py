"""Diagrams: everything is there, nothing overlaps, and the order of declaration changes nothing."""

import random
import re
from collections.abc import Iterator
from html import escape
from itertools import combinations, pairwise
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
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.drawing.diagram import subgraph_paths, svg
from proofmass.graphs.drawing.text_forms import dot, mermaid
from proofmass.graphs.files.library import library_file, library_files
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


def edges(graph: Graph) -> dict[str, Box]:
    """Boxes of what wires end at: symbols are smaller than the place of their blocks."""
    found: dict[str, Box] = {}
    for group in ElementTree.fromstring(svg(graph)).iter(f"{SVG}g"):
        if "data-block" in group.attrib:
            shape = next(one for one in group if one.attrib.get("class") == "box")
            if shape.tag == f"{SVG}path":  # a triangle
                x, y, side, across = (float(n) for n in re.findall(r"-?[\d.]+", shape.attrib["d"])[:4])
                found[group.attrib["data-block"]] = (min(x, x + across), y, max(x, x + across), y + side)
            else:
                x, y, width, height = (float(shape.attrib[name]) for name in ("x", "y", "width", "height"))
                found[group.attrib["data-block"]] = (x, y, x + width, y + height)
    return found


def straight(segments: list[Segment]) -> Iterator[Segment]:
    """Segments of a wire from corner to corner."""
    start, end = segments[0]
    for a, b in segments[1:]:
        if start[0] == end[0] == b[0] or start[1] == end[1] == b[1]:
            end = b
        else:
            yield start, end
            start, end = a, b
    yield start, end


def words_of(group: ElementTree.Element) -> Iterator[str | None]:
    """Texts of a block without those that only an overlay shows."""
    yield from (text.text for text in group.iter(f"{SVG}text") if "only" not in text.attrib.get("class", ""))


def within(segment: Segment, box: Box, margin: float) -> bool:
    """Whether some of the segment lies inside the box grown by the margin."""
    (x1, x2), (y1, y2) = (sorted(ends) for ends in zip(*segment, strict=True))
    left, top, right, bottom = box
    return x2 > left - margin and x1 < right + margin and y2 > top - margin and y1 < bottom + margin


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda graph: graph.name)
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


def test_units_are_written_as_by_hand() -> None:
    gain = Gain(input_unit="1", output_unit="kg*m^2/s^3/A", gain=1.0)
    assert ">kg·m²/s³/A</text>" in svg(Graph(name="", blocks={"gain": gain}, probes=["gain.output"]))


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


RUNNABLE = [
    name for name, path in library_files().items() if path.suffix == ".toml" and "[blocks" in path.read_text("utf-8")
]


@pytest.mark.parametrize("name", RUNNABLE)
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
