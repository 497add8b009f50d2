"""A graph is a frozen value: the same whatever the order of declaration, and refused with every fault at once."""

import copy
import dataclasses
import math
import pickle
import random
import subprocess
import sys
from fractions import Fraction
from typing import Any

import pytest

import proofmass
from proofmass.blocks import AnalogToDigital, Constant, Gain
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Place, Probe, Wire
from tests.by_hand.graph_texts import LIBRARY

BLOCKS = {"source": Constant(value=1.0, unit="V"), "adc": AnalogToDigital(bits=16), "gain": Gain()}


def small(**changes: Any) -> Graph:
    facts: dict[str, Any] = {
        "name": "small",
        "rate": "10 kHz",
        "duration": "1 s",
        "blocks": BLOCKS,
        "wires": ["source.output -> adc.voltage", "adc.number -> gain.input"],
        "probes": ["gain.output", Probe("adc.code", 10)],
        "rates": {"adc": "5 kHz"},
    }
    return Graph(**(facts | changes))


def messages(**changes: Any) -> list[str]:
    with pytest.raises(ModelError) as caught:
        small(**changes)
    return [f"{problem.key}: {problem.message}" for problem in caught.value.problems]


def test_texts_become_values() -> None:
    graph = small()
    assert graph.rate == Fraction(10_000)
    assert graph.duration == Fraction(1)
    assert graph.rates == {"adc": Fraction(5000)}
    assert graph.wires == (Wire("adc.number", "gain.input"), Wire("source.output", "adc.voltage"))
    assert graph.probes == (Probe("gain.output"), Probe("adc.code", 10))
    assert str(graph.wires[0]) == "adc.number -> gain.input"


def test_nothing_of_a_graph_can_be_changed() -> None:
    graph = small()
    with pytest.raises(dataclasses.FrozenInstanceError):
        graph.rate = Fraction(1)  # type: ignore[misc]
    with pytest.raises(TypeError):
        graph.blocks["more"] = Gain()  # type: ignore[index]
    with pytest.raises(TypeError):
        graph.rates["adc"] = Fraction(1)  # type: ignore[index]


def test_a_graph_does_not_follow_the_mapping_that_it_was_made_of() -> None:
    blocks = dict(BLOCKS)
    graph = small(blocks=blocks)
    blocks.clear()
    assert set(graph.blocks) == {"adc", "gain", "source"}


@pytest.mark.parametrize("seed", range(10))
def test_the_order_of_declaration_makes_no_difference(seed: int) -> None:
    draw = random.Random(seed)
    graph = small()
    blocks, wires = list(graph.blocks.items()), list(graph.wires)
    draw.shuffle(blocks)
    draw.shuffle(wires)
    other = small(blocks=dict(blocks), wires=wires)
    assert other == graph
    assert repr(other) == repr(graph)
    assert list(other.blocks) == list(graph.blocks)


def test_the_order_of_probes_is_kept() -> None:
    assert small(probes=["adc.code", "gain.output"]) != small(probes=["gain.output", "adc.code"])


def test_where_a_graph_was_read_from_is_no_part_of_its_value() -> None:
    assert small(place=Place("somewhere.toml")) == small()


@pytest.mark.exhaustive(but=35)
@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.stem)
def test_a_graph_can_be_copied_and_sent_to_another_process(path: Any) -> None:
    graph = read_graph(path)
    for other in (pickle.loads(pickle.dumps(graph)), copy.deepcopy(graph), dataclasses.replace(graph)):
        assert other == graph
        assert other.place == graph.place


def test_parameters_are_changed_in_a_new_graph() -> None:
    graph = small()
    changed = graph.with_parameters({"adc.reference": "500 mV", "adc.bits": 12, "gain.gain": 3})
    assert changed.blocks["adc"] == AnalogToDigital(bits=12, reference=0.5)
    assert changed.blocks["gain"] == Gain(gain=3.0)
    assert changed.blocks["source"] is graph.blocks["source"]
    assert graph.blocks["adc"] == AnalogToDigital(bits=16)
    assert changed.wires == graph.wires


def test_every_parameter_that_cannot_be_changed_is_named() -> None:
    with pytest.raises(ModelError) as caught:
        small().with_parameters({"acd.bits": 12, "adc.bist": 12, "adc.reference": "5 A", "gain": 3})
    assert (
        str(caught.value)
        == """\
acd.bits: there is no such block
  got:      'acd'
  hint:     did you mean adc?
adc.bist: AnalogToDigital has no such parameter
  got:      bist
  hint:     did you mean bits?
adc.reference: A is A, not m^2*kg/s^3/A
  got:      '5 A'
  expected: a number > 0, in V
  hint:     give it in V
gain.: Gain has no such parameter
  hint:     the parameters of Gain: gain, input_unit, output_unit."""
    )


@pytest.mark.parametrize(
    "name",
    [
        *("Adc", "2nd", "a__b", "a_", "_a", "a-b", "", "a" * 65, "a\n", "adс", "a b", "ａdc", "../x", "a\u202eb"),
        *("a.", ".a", "a..b", "a.B", ".".join(["a"] * 18)),
    ],
)
def test_bad_names_are_refused(name: str) -> None:
    assert messages(blocks=BLOCKS | {name: Gain()}) == ["blocks: not a name"]


@pytest.mark.parametrize("name", ["a", "a" * 64, "a1", "x_axis_2", "class", "loop", "p"])
def test_good_names_are_taken(name: str) -> None:
    assert name in small(blocks=BLOCKS | {name: Gain()}).blocks


def test_every_fault_is_said_at_once() -> None:
    found = messages(
        name=5,
        description="\ud800",
        rate="fast",
        duration=-1,
        seed=-1,
        wires=["source.output -> adc.voltage", "nonsense", 3, "a.b -> c.d -> e.f", "A.b -> c.d", None],
        probes=["adc", {"signal": "adc.code", "evry": 3}, {"signal": "adc.code", "every": 0}, 7],
        rates={"adc": "0 s", "acd": "1 Hz"},
        blocks=BLOCKS | {"Bad": Gain(), "kind": Gain},
    )
    assert found == [
        "name: must be a string",
        "description: holds half a character",
        "seed: out of range",
        "blocks: not a name",
        "blocks.kind: not a block",
        "rates.acd: there is no such block",
        "blocks.adc.rate: must be above 0 Hz",
        "rate: not a number followed by a unit",
        "duration: must not be negative",
        "wires.1: not a wire",
        "wires.2: not a wire",
        "wires.3: not a wire",
        "wires.4: not a wire",
        "wires.5: not a wire",
        "probes.0: not a probe",
        "probes.1: not a probe",
        "probes.2: every must be an integer of at least 1",
        "probes.3: not a probe",
    ]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"duration": None, "samples": 0}, "samples: out of range"),
        ({"duration": None, "samples": 10**12 + 1}, "samples: out of range"),
        ({"duration": None, "samples": 1e6}, "samples: must be an integer"),
        ({"duration": None, "samples": True}, "samples: must be an integer"),
        ({"duration": None, "samples": math.nan}, "samples: must be an integer"),
        ({"samples": 5}, "samples: give samples or duration, not both"),
        ({"seed": 2**62 + 1}, "seed: out of range"),
        ({"seed": None}, "seed: must be an integer"),
        ({"wires": "source.output -> adc.voltage"}, "wires: must be a list"),
        ({"probes": "adc.code"}, "probes: must be a list"),
        ({"name": "x" * 10_001}, "name: longer than 10000 characters"),
    ],
)
def test_what_a_run_cannot_take_is_refused(changes: dict[str, Any], message: str) -> None:
    assert messages(**changes) == [message]


def test_a_whole_number_with_a_point_is_told_how_to_write_it() -> None:
    with pytest.raises(ModelError) as caught:
        small(duration=None, samples=1e6)
    assert caught.value.problems[0].hint == "write it without a point or an exponent: samples = 1000000"


def test_a_class_instead_of_a_block_is_told_how_to_write_it() -> None:
    with pytest.raises(ModelError) as caught:
        small(blocks=BLOCKS | {"more": Gain})
    assert caught.value.problems[0].hint == "write Gain()"


def test_networkx_gets_a_node_per_block_and_an_edge_per_wire() -> None:
    network = small().to_networkx()
    assert network.nodes["adc"] == {"kind": "AnalogToDigital"} | {
        name: getattr(AnalogToDigital(bits=16), name) for name in AnalogToDigital.parameters
    }
    assert list(network.edges(data=True)) == [
        ("adc", "gain", {"source": "number", "target": "input"}),
        ("source", "adc", {"source": "output", "target": "voltage"}),
    ]


def test_a_place_gives_the_line_of_the_nearest_key_above() -> None:
    place = Place("a.toml", {("blocks",): 3, ("blocks", "adc"): 5})
    assert [place.line(path) for path in [("blocks", "adc", "bits"), ("blocks", "x"), ("wires",)]] == [5, 3, 0]


def test_a_changed_graph_is_the_one_that_is_built_anew() -> None:
    graph = small()
    changed = graph.changed(probes=(Probe("adc.code"),), wires=tuple(reversed(graph.wires)), seed=7)
    assert changed == small(probes=["adc.code"], seed=7)
    assert isinstance(changed, Graph)
    assert list(changed.wires) == sorted(graph.wires)


def test_every_field_is_in_the_flat_graph_or_the_same_in_its_root() -> None:
    """A field of a graph that holds names must be flattened; no other may differ from what the graph says."""
    named = {"blocks", "rates", "wires", "probes", "measures", "exports", "loops"}
    flat = flatten(Graph(name="outer", rate="1 kHz", blocks={"part": small(), "gain": Gain()}, seed=3))
    for field in dataclasses.fields(flat.root):
        if field.name in named:
            assert field.name in {own.name for own in dataclasses.fields(flat)}
        elif field.name != "subgraphs":
            assert getattr(flat.as_graph(), field.name) == getattr(flat.root, field.name)


def test_a_graph_shows_itself_where_pictures_are_known() -> None:
    assert str(proofmass.Graph(name="", blocks={})._repr_svg_()).startswith("<svg")


@pytest.mark.exhaustive
def test_a_notebook_shows_the_diagram() -> None:
    code = "import proofmass; graph = proofmass.Graph(name='', blocks={}); print(graph._repr_svg_()[:4])"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True).stdout
    assert shown == "<svg\n"
