"""Graphs to draw, and what a picture shows, read back from its SVG."""

import random
import re
from collections.abc import Iterator
from itertools import pairwise
from xml.etree import ElementTree

from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    DigitalToAnalog,
    FlexurePendulum,
    Gain,
    Negation,
    Sum,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.drawing.diagram import svg
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


_PICTURES: dict[int, ElementTree.Element] = {}  # of `GRAPHS`, which several tests look at


def _picture(graph: Graph) -> ElementTree.Element:
    if not any(graph is known for known in GRAPHS):
        return ElementTree.fromstring(svg(graph))
    if id(graph) not in _PICTURES:
        _PICTURES[id(graph)] = ElementTree.fromstring(svg(graph))
    return _PICTURES[id(graph)]


def drawn(graph: Graph) -> tuple[dict[str, Box], dict[str, list[Segment]]]:
    """Boxes of the blocks and segments of the wires, read back from the picture: two pieces of one that is named."""
    root = _picture(graph)
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
            wires[group.attrib["data-wire"]] = [
                (a, b) for piece in reach.attrib["d"].split("M")[1:] for a, b in pairwise(_points(piece)) if a != b
            ]
    return boxes, wires


def _points(piece: str) -> list[tuple[float, float]]:
    numbers = [float(n) for n in re.findall(r"-?[\d.]+", piece)]
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def box_of(path: str) -> Box:
    """The smallest box around a path of straight lines."""
    x = y = 0.0
    points = list[tuple[float, float]]()
    for command, rest in re.findall(r"([MHhVvlLZ])([^MHhVvlLZ]*)", path):
        numbers = [float(number) for number in re.findall(r"-?[\d.]+", rest)]
        if command in "ML":
            x, y = numbers
        elif command == "l":
            x, y = x + numbers[0], y + numbers[1]
        elif command in "Hh":
            x = numbers[0] + (x if command == "h" else 0)
        elif command in "Vv":
            y = numbers[0] + (y if command == "v" else 0)
        points.append((x, y))
    across, down = zip(*points, strict=True)
    return min(across), min(down), max(across), max(down)


def edges(graph: Graph) -> dict[str, Box]:
    """Boxes of what wires end at: symbols are smaller than the place of their blocks."""
    found: dict[str, Box] = {}
    for group in _picture(graph).iter(f"{SVG}g"):
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
