"""A diagram as data: the places are those of the SVG, the wires those of the graph."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from proofmass.graphs.drawing.diagram import subgraph_paths, svg
from proofmass.graphs.drawing.diagram_data import diagram_data
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.flatten import flatten
from proofmass.runner.command_line import main

_GROUP, _WIRE = "{http://www.w3.org/2000/svg}g", "{http://www.w3.org/2000/svg}path"
_MOVED, _NUMBER = re.compile(r"translate\((-?[\d.]+) (-?[\d.]+)\)"), re.compile(r"-?[\d.]+")


def places(text: str) -> tuple[dict[str, tuple[float, float]], dict[str, tuple[float, float]]]:
    """Upper left corners of blocks, and first points of wires, on the whole picture."""
    corners, starts = dict[str, tuple[float, float]](), dict[str, tuple[float, float]]()

    def walk(node: ElementTree.Element, x: float, y: float) -> None:
        if moved := _MOVED.fullmatch(node.get("transform", "")):
            x, y = x + float(moved[1]), y + float(moved[2])
        if "data-block" in node.attrib:
            place = next(child for child in node if child.tag.endswith("rect"))  # also of symbols, which are smaller
            corners[node.attrib["data-block"]] = x + float(place.attrib["x"]), y + float(place.attrib["y"])
        for child in node:
            walk(child, x, y)
        if "data-wire" in node.attrib:
            reach = next(child for child in node if child.get("class") == "reach")
            first = [float(number) for number in _NUMBER.findall(reach.attrib["d"])[:2]]
            starts[node.attrib["data-wire"].replace(" \u2192 ", ">")] = x + first[0], y + first[1]

    walk(ElementTree.fromstring(text), 0.0, 0.0)
    return corners, starts


@pytest.mark.parametrize("name", ["open_loop_gyroscope", "closed_loop_fluxgate"])
@pytest.mark.parametrize("opened", [False, True])
def test_data_and_svg_agree(name: str, opened: bool) -> None:
    graph = read_graph(f"library:{name}")
    unfolded = subgraph_paths(graph) if opened else ()
    data = diagram_data(graph, unfolded)
    corners, starts = places(svg(graph, unfolded))
    found = {block["name"]: (block["x"], block["y"]) for block in data["blocks"]}
    assert len(corners) >= 8
    assert {block: place for block, place in corners.items() if "\u2192" not in block} == found
    drawn = {f"{wire['from']}>{wire['to']}": tuple(wire["points"][0]) for wire in data["wires"]}
    same = [key for key in starts.keys() & drawn.keys() if starts[key] == drawn[key]]
    assert len(same) > 0.5 * len(starts), "the others begin at symbols, inside their blocks, or at tabs"
    if opened:
        assert {block["name"] for block in data["blocks"] if not block["subgraph"]} == set(flatten(graph).blocks)
    assert sum(wire["drives_parameter"] for wire in data["wires"]) == sum(
        len(block["driven"]) for block in data["blocks"]
    )


def test_draw_prints_data_and_still_writes_its_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "loop.svg"
    assert main(["draw", "library:phase_locked_loop", "--json", "--out", str(path)]) == 0
    told = capsys.readouterr()
    data = json.loads(told.out)
    assert told.err == f"wrote {path}\n"
    assert path.read_text(encoding="utf-8").startswith("<svg")
    oscillator = next(block for block in data["blocks"] if block["name"] == "oscillator")
    assert oscillator["kind"] == "NumericallyControlledOscillator"
    assert oscillator["inputs"]["control"] == {"unit": "Hz", "from": "loop_filter.control"}
    assert oscillator["settings"] == ["frequency 50 kHz"]
    assert {wire["unit"] for wire in data["wires"]} == {"1", "Hz", "rad"}


def test_schema_takes_json_like_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    plain = capsys.readouterr().out
    assert main(["schema", "--json"]) == 0
    assert capsys.readouterr().out == plain
