"""Long wires that are named and parallel ones that run as one: what is drawn, and how much less there is to follow."""

import re
from collections.abc import Iterable
from itertools import combinations, pairwise
from xml.etree import ElementTree

import pytest

from proofmass.blocks import Constant, Gain, MeasurementSlots, Sum, TwoPositionComparison
from proofmass.graphs.drawing import eased
from proofmass.graphs.drawing.diagram import subgraph_paths, svg
from proofmass.graphs.drawing.diagram_data import diagram_data
from proofmass.graphs.drawing.tabs import tab_of_wire
from proofmass.graphs.drawing.texts import width_of
from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from tests.by_hand.diagrams import SVG, Box, Segment, accelerometer, box_of, chain, drawn, random_graph, within

LARGE = {
    "quartz_recalibration": lambda: read_graph("library:quartz_recalibration"),
    "quartz_calibration": lambda: read_graph("library:quartz_calibration"),
    "self_calibration_online": lambda: read_graph("library:self_calibration_online"),
    "random": lambda: random_graph(2, 90),
    "chain": lambda: chain(900),
}
SMALL = [
    name
    for name in ("imu_3dof", "closed_loop_accelerometer", "quartz_accelerometer", "open_loop_gyroscope")
    if f"{name}.toml" in library_files()
]


FILL = "pqrstuvwxyz"


def parallel(wires: int) -> Graph:
    """Slots, from which one wire goes through nine gains and others go past them, and what makes the diagram large."""
    gains = [f"g{i}" for i in range(9)]
    way = ["slots.slot", *(f"{name}.output" for name in gains)]
    past = list(zip(("measure", "read", "finished"), ("second", "third", "fourth"), strict=True))[:wires]
    others = {f"{name}{i}": Gain() for name in FILL for i in range(5)} | {f"c{name}": Constant() for name in FILL}
    fill = [f"c{name}.output -> {name}{i}.input" for name in FILL for i in range(5)]
    blocks = {"slots": MeasurementSlots(), "sum": Sum(), **{name: Gain() for name in gains}, **others}
    return Graph(
        name="parallel",
        rate=1,
        blocks=blocks,
        wires=[f"{a} -> {b}" for a, b in zip(way, [*(f"{g}.input" for g in gains), "sum.first"], strict=True)]
        + [f"slots.{output} -> sum.{port}" for output, port in past]
        + fill,
    )


def tabs(graph: Graph) -> dict[Box, str]:
    """Names on tabs by their boxes, read back from the picture."""
    found: dict[Box, str] = {}
    for group in ElementTree.fromstring(svg(graph)).iter(f"{SVG}g"):
        if group.get("class") == "named":
            parts = list(group)
            for outline, label in pairwise(parts):
                if outline.get("class") == "label":
                    found[box_of(outline.attrib["d"])] = str(label.text)
    return found


def crossings(wires: dict[str, list[Segment]]) -> int:
    """Points at which wires of different outputs cross."""
    level, upright = set[tuple[str, float, float, float]](), set[tuple[str, float, float, float]]()
    for wire, segments in wires.items():
        source = wire.split(" → ")[0]
        for (x1, y1), (x2, y2) in segments:
            if y1 == y2:
                level.add((source, y1, min(x1, x2), max(x1, x2)))
            else:
                upright.add((source, x1, min(y1, y2), max(y1, y2)))
    return len(
        {
            (x, y)
            for a, y, left, right in level
            for b, x, top, low in upright
            if a != b and left < x < right and top < y < low
        }
    )


def lengths(wires: dict[str, list[Segment]]) -> dict[str, float]:
    """Drawn length of each wire."""
    return {name: sum(abs(b[0] - a[0]) + abs(b[1] - a[1]) for a, b in parts) for name, parts in wires.items()}


def texts(graph: Graph, group: str) -> Iterable[ElementTree.Element]:
    return (one for one in ElementTree.fromstring(svg(graph)).iter(f"{SVG}g") if one.get("class") == group)


@pytest.mark.exhaustive("chain", "quartz_recalibration", "random", "quartz_calibration")
@pytest.mark.parametrize("name", LARGE)
def test_a_large_diagram_has_less_to_follow(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = LARGE[name]()
    _, wires = drawn(graph)
    monkeypatch.setattr(eased, "PAGE", 10**9)
    _, before = drawn(graph)
    assert max(lengths(before).values()) > eased.LONGEST >= max(lengths(wires).values())
    assert sum(lengths(wires).values()) < 0.6 * sum(lengths(before).values())
    assert crossings(wires) <= 0.4 * crossings(before)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", LARGE)
def test_tabs_stand_free_and_name_both_ends(name: str) -> None:
    graph = LARGE[name]()
    boxes, wires = drawn(graph)
    names = tabs(graph)
    named = {f"{one['from']} → {one['to']}": one for one in diagram_data(graph)["wires"] if "named" in one}
    assert len(named) > 5
    sources = {wire.split(" → ")[0]: one["named"] for wire, one in named.items()}
    assert len(set(sources.values())) == len(sources), "no two nets have one name"
    assert sorted(names.values()) == sorted([*sources.values(), *(one["named"] for one in named.values())])
    for first, second in combinations([*names, *boxes.values()], 2):
        assert first[2] < second[0] or second[2] < first[0] or first[3] < second[1] or second[3] < first[1]
    for wire, segments in wires.items():
        for box, label in names.items():
            if label != sources.get(wire.split(" → ")[0]):
                assert not any(within(segment, box, 0.0) for segment in segments), (wire, label)


@pytest.mark.parametrize("name", SMALL)
def test_a_diagram_that_fits_a_page_does_not_change(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = read_graph(f"library:{name}")
    drawing = svg(graph)
    assert not re.search('class="(named|bundle|label)"', drawing)
    monkeypatch.setattr(eased, "PAGE", 10**9)
    assert svg(graph) == drawing


@pytest.mark.exhaustive
def test_a_wire_that_is_named_keeps_its_signal_its_ends_and_its_words() -> None:
    graph = LARGE["quartz_recalibration"]()
    nets = {group.attrib["data-net"]: list(group) for group in texts(graph, "named")}
    about = {f"{one['from']} → {one['to']}": one for one in diagram_data(graph)["wires"]}
    for signal, parts in nets.items():
        groups = [one for one in parts if "data-wire" in one.attrib]
        assert groups
        for group in groups:
            assert group.attrib["data-signal"] == signal
            assert about[group.attrib["data-wire"]]["signal"] == signal
            assert str(group[0].text).startswith(group.attrib["data-wire"])


@pytest.mark.parametrize("wires", [2, 3])
def test_parallel_wires_run_as_one_and_part_at_their_ports(wires: int) -> None:
    graph = parallel(wires)
    (bundle,) = texts(graph, "bundle")
    signals = [f"slots.{output}" for output in ("measure", "read", "finished")[:wires]]
    assert sorted(bundle.attrib["data-signals"].split()) == sorted(signals)
    assert str(bundle[0].text).startswith(f"{wires} wires\n")
    (count,) = (one for one in bundle if one.tag == f"{SVG}text")
    assert count.text == str(wires)
    _, paths = drawn(graph)
    own = [
        paths[f"{signal} → sum.{port}"] for signal, port in zip(signals, ("second", "third", "fourth"), strict=False)
    ]
    assert all(a == to or b == down for segments in own for (a, b), (to, down) in segments)
    assert all(segments[0][0][0] < float(count.attrib["x"]) < segments[-1][1][0] for segments in own)
    assert len({segments[0][0] for segments in own}) == wires
    assert len({segments[-1][1] for segments in own}) == wires
    shared = set.intersection(*(set(segments) for segments in own))
    assert sum(abs(b[0] - a[0]) + abs(b[1] - a[1]) for a, b in shared) > 0.8 * min(
        sum(abs(b[0] - a[0]) + abs(b[1] - a[1]) for a, b in segments) for segments in own
    )


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_name_of_a_wire_stands_within_its_tab(mirrored: bool) -> None:
    wide = width_of("torque", 10)
    tab = tab_of_wire("torque", (100.0, 40.0), wide + 20, mirrored, "")
    outline, label = ElementTree.fromstring(f"<g>{tab}</g>")
    left, _, right, _ = box_of(outline.attrib["d"])
    assert (left if mirrored else right) == 100.0
    assert left < float(label.attrib["x"]) - wide / 2
    assert float(label.attrib["x"]) + wide / 2 < right


def test_the_type_of_an_output_stands_beside_its_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(eased, "PAGE", 0)
    monkeypatch.setattr(eased, "LONGEST", 100)
    root, stands = ElementTree.fromstring(svg(accelerometer(), overlay="formats")), 0
    assert len(list(root.iterfind(f".//{SVG}g[@class='named']"))) > 3
    for block in root.iterfind(f".//{SVG}g[@data-block]"):
        rect = next(block.iter(f"{SVG}rect"))
        left, wide = float(rect.attrib["x"]), float(rect.attrib["width"])
        for words in block.iterfind(f"{SVG}text"):
            if "formats" in words.get("class", ""):
                stands += 1
                assert not left < float(words.attrib["x"]) < left + wide, words.text
    assert stands > 5


def test_wires_that_lead_elsewhere_or_stand_alone_are_in_no_bundle() -> None:
    assert not list(texts(parallel(1), "bundle"))
    graph = parallel(2)
    more = [*map(str, graph.wires), "slots.read -> test.read"]
    blocks = {**graph.blocks, "test": TwoPositionComparison()}
    assert not list(texts(Graph(name="", rate=1, blocks=blocks, wires=more), "bundle"))


@pytest.mark.exhaustive("quartz_recalibration")
@pytest.mark.parametrize("name", ["quartz_recalibration", "closed_loop_gyroscope"])
def test_no_word_and_no_flag_stands_on_a_tab(name: str) -> None:
    graph = read_graph(f"library:{name}")
    root = ElementTree.fromstring(svg(graph, subgraph_paths(graph), "formats"))
    layer = next(group for group in root if "translate" in group.get("transform", ""))
    outlines = [box_of(one.attrib["d"]) for group in layer for one in group if one.get("class") == "label"]
    assert len(outlines) > 5
    for block in (group for group in layer if "data-block" in group.attrib):
        for mark in block:
            if mark.get("class") == "probe":
                box = box_of(mark.attrib["d"].replace("m0 0", ""))
                assert not any(_meet(box, outline) for outline in outlines), mark.attrib
            if mark.tag == f"{SVG}text" and "formats" in mark.get("class", ""):
                wide = width_of(str(mark.text), 10) * (-1 if mark.get("text-anchor") == "end" else 1)
                (left, right), y = (
                    sorted((float(mark.attrib["x"]), float(mark.attrib["x"]) + wide)),
                    float(mark.attrib["y"]),
                )
                assert not any(_meet((left, y - 7, right, y), outline) for outline in outlines), mark.text


def _meet(first: Box, second: Box) -> bool:
    return first[0] < second[2] and second[0] < first[2] and first[1] < second[3] and second[1] < first[3]
