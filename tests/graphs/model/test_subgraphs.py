"""Subgraphs: from files and from Python, exports, paths, rates, parameters from outside, and what goes wrong."""

import copy
import pickle
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks import Constant, DisplacementReadout, Gain, UnitDelay
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check, checked
from proofmass.graphs.checks.schedule import schedule
from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.drawing.text_forms import dot, mermaid
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Wire
from proofmass.graphs.model.limits import DEPTH
from proofmass.runner.run.simulate import simulate
from tests.by_hand.graph_texts import changed
from tests.by_hand.parts import CHANNEL, THREE_AXES, said, write_parts

PAIR = Graph(
    name="pair",
    blocks={"first": Gain(gain=2.0), "second": Gain(gain=3.0)},
    wires=["first.output -> second.input"],
    exports={"entry": "first.input", "result": "second.output", "factor": "first.gain"},
)


def outer(part: Graph, **changes: Any) -> Graph:
    facts: dict[str, Any] = {
        "name": "outer",
        "rate": 10,
        "blocks": {"one": Constant(value=1.0), "part": part},
        "wires": ["one.output -> part.entry"],
        "probes": ["part.result"],
    }
    return Graph(**(facts | changes))


def test_the_flat_graph_has_paths_for_names_and_wires_to_the_blocks_inside(tmp_path: Path) -> None:
    graph = read_graph(write_parts(tmp_path))
    flat = flatten(graph)
    inner = ("sensor", "readout", "channel.amplifier", "channel.adc")
    assert set(flat.blocks) == {"push", "after", *(f"axis_{n}.{name}" for n in (1, 2, 3) for name in inner)}
    assert flat.as_graph().subgraphs == {}
    assert Wire("push.output", "axis_1.sensor.force") in flat.wires
    assert Wire("axis_2.channel.adc.number", "after.input") in flat.wires
    assert [probe.signal for probe in flat.probes[:3]] == [f"axis_{n}.channel.adc.code" for n in (1, 2, 3)]
    assert graph.size == (len(flat.blocks), len(flat.wires), 2)
    assert flatten(flat.as_graph()).as_graph() == flat.as_graph()
    assert flatten(read_graph_text(write_graph(graph))) == flat
    assert read_graph_text(write_graph(flat.as_graph())) == flat.as_graph()
    assert pickle.loads(pickle.dumps(flat)) == flat
    assert pickle.loads(pickle.dumps(flat.as_graph())) == flat.as_graph()


def test_a_subgraph_is_a_value() -> None:
    graph = outer(PAIR)
    assert graph == outer(copy.deepcopy(PAIR))
    assert graph != outer(PAIR.with_parameters({"factor": 4}))
    for other in (pickle.loads(pickle.dumps(graph)), copy.deepcopy(graph), read_graph_text(write_graph(graph))):
        assert other == graph
        assert repr(other) == repr(graph)
    with pytest.raises(TypeError):
        graph.subgraphs["part"] = PAIR  # type: ignore[index]


def test_what_a_subgraph_looks_like_in_a_file() -> None:
    assert (
        write_graph(outer(PAIR)).partition("[blocks.part]")[2]
        == """
name = "pair"

wires = [
    "first.output -> second.input",
]

[blocks.part.exports]
entry = "first.input"
factor = "first.gain"
result = "second.output"

[blocks.part.blocks.first]
kind = "Gain"
gain = 2.0

[blocks.part.blocks.second]
kind = "Gain"
gain = 3.0
"""
    )


def test_three_axes_from_one_file_run_alike_in_both_engines(tmp_path: Path) -> None:
    graph = read_graph(write_parts(tmp_path))
    python, compiled = (simulate(graph, engine=engine) for engine in ("python", "compiled"))
    assert list(python) == ["axis_1.code", "axis_2.code", "axis_3.channel.adc.code", "after.output"]
    for name in python:
        assert (python[name].values == compiled[name].values).all()
    assert (python["axis_1.code"].values == python["axis_3.channel.adc.code"].values).all()
    assert python["axis_1.code"].values[-1] == round(1e-6 / 49.5627 * DisplacementReadout().gain / 8 * 2**13)


def test_parameters_are_reached_from_outside(tmp_path: Path) -> None:
    top = changed(THREE_AXES, 'reference = "8 V"', 'reference = "8 V"\n"channel.adc.bits" = 16\nreadout.gain = 3')
    graph = read_graph(write_parts(tmp_path, top=top))
    assert {(a.bits, a.reference) for name, a in blocks_of(graph) if name.endswith("adc")} == {(16, 8.0)}
    assert {r.gain for name, r in blocks_of(graph) if name.endswith("readout")} == {3.0}
    graph = graph.with_parameters({"axis_2.channel.adc.bits": 8, "axis_3.reference": "500 mV"})
    found = [(a.bits, a.reference) for name, a in blocks_of(graph) if name.endswith("adc")]
    assert found == [(16, 8.0), (8, 8.0), (16, 0.5)]
    alone = read_graph(tmp_path / "axis.toml").with_parameters({"reference": "2 V"})
    assert dict(blocks_of(alone))["channel.adc"].reference == 2.0


def blocks_of(graph: Graph) -> list[tuple[str, Any]]:
    return list(flatten(graph).blocks.items())


def test_parameters_that_are_not_there_are_named_with_their_path(tmp_path: Path) -> None:
    graph = read_graph(write_parts(tmp_path))
    with pytest.raises(ModelError) as caught:
        graph.with_parameters(
            {
                "axis_2.channel.adc.bist": 8,
                "axis_2.refrence": 1,
                "axis_1.channel.acd.bits": 8,
                "axis_1.reference": "1 A",
                "axis_4.reference": 1,
            }
        )
    assert [(problem.key, problem.hint) for problem in caught.value.problems] == [
        ("axis_4.reference", "did you mean axis_3?"),
        ("axis_2.refrence", "did you mean reference?"),
        ("axis_1.channel.acd.bits", "did you mean adc?"),
        ("axis_1.channel.adc.reference", "give it in V"),
    ]


@pytest.mark.defect(
    "H896", before="`did you mean channel?` of channel, and ports among the names", after="what to write"
)
@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("channel", 'channel is a subgraph: name a value or parameter of it, as "channel.PARAMETER"'),
        ("readout", 'readout is a block: name a parameter of it, as "readout.gain"'),
        ("zzz", 'its values and the parameters that it exports: reference. One inside: "block.parameter" = ...'),
    ],
)
def test_what_may_be_written_of_a_subgraph(name: str, hint: str, tmp_path: Path) -> None:
    graph = read_graph(write_parts(tmp_path))
    with pytest.raises(ModelError, match="exports no such parameter") as caught:
        graph.with_parameters({f"axis_2.{name}": 1})
    assert [problem.hint for problem in caught.value.problems] == [hint]


def test_a_name_without_a_dot_is_a_value(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="there is no such value") as caught:
        read_graph(write_parts(tmp_path)).with_parameters({"zzz": 1})
    assert caught.value.problems[0].hint.startswith("its values and the parameters that it exports: none.")


def test_a_parameter_may_be_driven_through_its_export() -> None:
    drive = {"one": Constant(value=1.0), "two": Constant(value=5.0), "part": PAIR}
    graph = outer(PAIR, blocks=drive, wires=["one.output -> part.entry", "two.output -> part.factor"])
    assert check(graph) == []
    assert simulate(graph, samples=1, engine="python")["part.result"].values[0] == 15.0


def test_rates_inside_are_their_own_then_those_of_the_place_then_those_around(tmp_path: Path) -> None:
    rates = flatten(read_graph(write_parts(tmp_path))).rates
    assert rates["axis_1.readout"] == 10_000
    assert rates["axis_1.channel.adc"] == 5_000
    assert "after" not in rates
    assert "axis_1.sensor" not in rates
    top = changed(THREE_AXES, "count = 3", 'count = 3\nrate = "40 kHz"')
    rates = flatten(read_graph(write_parts(tmp_path, top=top))).rates
    assert rates["axis_1.readout"] == 40_000
    assert rates["axis_1.channel.adc"] == 5_000
    inner = Graph(name="", blocks={"slow": UnitDelay(), "other": UnitDelay()}, rates={"slow": 2})
    made = Graph(name="", rate=8, blocks={"part": inner}, rates={"part": 4})
    assert flatten(made).rates == {"part.slow": 2, "part.other": 4}
    assert made.subgraphs["part"].rate == Fraction(4)
    assert made.rates == {}


def test_five_levels() -> None:
    graph = PAIR
    for level in range(4):
        exports = {"entry": "part.entry", "result": "part.result", "factor": "part.factor"}
        graph = Graph(name=f"level {level}", blocks={"part": graph}, exports=exports)
    graph = outer(graph)
    assert graph.size.depth == 5
    assert check(graph) == []
    path = "part.part.part.part.part"
    assert set(flatten(graph).blocks) == {"one", f"{path}.first", f"{path}.second"}
    changed_graph = graph.with_parameters({"part.factor": 10, f"{path}.second.gain": 0.5})
    for engine in ("python", "compiled"):
        assert simulate(changed_graph, samples=3, engine=engine)["part.result"].values.tolist() == [5.0] * 3  # type: ignore[arg-type]
    assert read_graph_text(write_graph(graph)) == graph


def test_the_deepest_nesting_and_one_more() -> None:
    graph = PAIR
    for _ in range(DEPTH):
        graph = Graph(name="", blocks={"part": graph})
    assert read_graph_text(write_graph(graph)) == graph
    with pytest.raises(ModelError, match="subgraphs nested deeper than 15 levels"):
        Graph(name="", blocks={"part": graph})


def test_networkx_gets_the_flat_graph() -> None:
    network = outer(PAIR).to_networkx()
    assert set(network.nodes) == {"one", "part.first", "part.second"}
    assert ("one", "part.first") in network.edges()


def test_a_loop_without_delay_through_subgraphs_is_named_by_its_paths() -> None:
    graph = outer(PAIR, blocks={"part": PAIR}, wires=["part.result -> part.entry"])
    (problem,) = check(graph)
    assert problem.got == "part.first.output -> part.second.input, part.second.output -> part.first.input"
    with pytest.raises(ModelError):
        schedule(flatten(graph))


def test_recordings_are_named_from_the_folder_of_the_file_that_plays_them(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "motion.csv").write_text("time [s],signal\n0,1\n1,2\n")
    player = '[blocks.motion]\nkind = "RecordedSignal"\nfile = "motion.csv"\n[exports]\nsignal = "motion.output"\n'
    (tmp_path / "parts" / "player.toml").write_text(player)
    (tmp_path / "top.toml").write_text(
        'rate = 2\nprobes = ["player.signal"]\n[blocks.player]\ngraph = "parts/player.toml"\n'
    )
    graph = read_graph(tmp_path / "top.toml")
    assert dict(blocks_of(graph))["player.motion"].file == "parts/motion.csv"
    assert simulate(graph, samples=3)["player.signal"].values.tolist()[0] == 1.0
    again = read_graph_text(write_graph(graph), folder=str(tmp_path))
    assert again == graph
    made = Graph(name="", rate=2, blocks={"player": read_graph(tmp_path / "parts" / "player.toml")})
    assert dict(blocks_of(made))["player.motion"].file == str(tmp_path / "parts" / "motion.csv")


def test_a_part_alone_is_told_from_a_graph_that_runs(tmp_path: Path) -> None:
    write_parts(tmp_path)
    axis, channel = (read_graph(tmp_path / name) for name in ("axis.toml", "parts/channel.toml"))
    assert [(p.note, p.key) for p in check(axis)] == [(True, "exports.force")]
    assert [(p.note, p.key) for p in check(channel)] == [(True, "rate")]
    assert not runs_alone(flatten(axis))
    assert not runs_alone(flatten(channel))
    assert runs_alone(flatten(outer(PAIR)))
    with pytest.raises(ModelError, match="the graph is a part of others and cannot run alone"):
        checked(axis)


def test_a_problem_inside_names_file_line_and_path_once_for_all_of_an_array(tmp_path: Path) -> None:
    channel = changed(CHANNEL, "amplifier.output ->", "amplifier.outptu ->")
    assert (
        said(tmp_path, channel=changed(channel, 'output_unit = "V"', 'output_unit = "mV"'))
        == """\
parts/channel.toml:2: wires: axis_1.channel.amplifier.outptu -> axis_1.channel.adc.voltage: \
axis_1.channel.amplifier.outptu is not an output
  hint:     did you mean output?"""
    )
    assert (
        said(tmp_path, channel=changed(CHANNEL, 'output_unit = "V"', 'output_unit = "mV"'))
        == """\
parts/channel.toml:2: wires: axis_1.channel.amplifier.output -> axis_1.channel.adc.voltage: \
the units differ by a factor of 0.001
  got:      mV
  expected: V
  hint:     put a Gain with input_unit = "mV" and output_unit = "V" between"""
    )


def test_a_problem_inside_a_table_has_its_line() -> None:
    text = write_graph(outer(PAIR)).replace("gain = 3.0", "gian = 3.0")
    with pytest.raises(ModelError) as caught:
        read_graph_text(text, "model.toml")
    (problem,) = caught.value.problems
    assert problem.key == "blocks.part.blocks.second.gian"
    assert text.split("\n")[problem.line - 1] == "gian = 3.0"


def test_a_block_cannot_be_added_inside_a_subgraph() -> None:
    with pytest.raises(ModelError) as caught:
        outer(PAIR, blocks={"part": PAIR, "part.first": Gain()})
    assert caught.value.problems[0].message == "there is a block part, and nothing can be added inside it"


def test_a_diagram_shows_a_subgraph_as_one_box(tmp_path: Path) -> None:
    graph = read_graph(write_parts(tmp_path))
    picture = svg(graph)
    assert 'data-block="axis_1"' in picture
    assert 'data-wire="push.output → axis_1.force"' in picture
    assert 'data-wire="axis_2.channel.number → after.input"' in picture
    assert "sensor</text>" not in picture
    box = picture.partition('data-block="axis_1"')[2].partition("</g>")[0]
    assert box.count('class="box"') == 2
    assert "reference = 8 V" in box
    assert 'block_axis_1[["axis_1<br/>Graph<br/>10 kHz"]]' in mermaid(graph)
    assert '"axis_1" [label="axis_1\\nGraph\\n10 kHz", peripheries=2]' in dot(graph)
    assert "block_axis_1__sensor(" in mermaid(flatten(graph).as_graph())
