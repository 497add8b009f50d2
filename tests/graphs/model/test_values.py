"""Named values of graphs: what they resolve to, what changes with them, and the same from text and from Python."""

import math
import pickle
from fractions import Fraction

import pytest

from proofmass.blocks import Constant, DisplacementReadout, Gain, MassSpringDamper
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.dependence import Dependence
from proofmass.graphs.model.flatten import flatten
from tests.by_hand.graph_texts import problems_of

TEXT = """\
name = "values"
rate = "= 16 * f0"
duration = "= periods / f0"
wires = [
    "push.output -> sensor.force",
    "sensor.displacement -> readout.displacement",
    "sensor.displacement -> axis.x",
    "push.output -> pair_1.force",
    "push.output -> pair_2.force",
    "axis.y -> filter.input",
]
probes = ["readout.voltage", "axis.y"]

[values]
mass = "50.43 ug"
f0 = "8 kHz"
q = 100
periods = 40
order = 2
stiffness = "= mass * (2 * pi * f0)^2"
damping = "= 2 * pi * f0 * mass / q"

[blocks.push]
kind = "Constant"
value = "1 uN"
unit = "N"

[blocks.sensor]
kind = "MassSpringDamper"
mass = "= mass"
stiffness = "= stiffness"
damping = "= damping"

[blocks.readout]
kind = "DisplacementReadout"
gain = "2e5 V/m"

[blocks.axis]
exports = { x = "amplifier.input", y = "amplifier.output", scale = "single" }
values = { single = "2 V/m", twice = "= single * 2" }
blocks.amplifier = { kind = "Gain", gain = "= twice", input_unit = "m", output_unit = "V" }

[blocks.filter]
kind = "DiscreteTransferFunction"
input_unit = "V"
output_unit = "V"
numerator = [1, "= -q / 100", 0.5]
denominator = [1, 0.5, 0.25]

[formulas]
"axis.scale" = "= 3 V/m * q"
"""
PART = """\
exports = { force = "sensor.force" }
values = { mass = "1 mg", heavy = "= 2 * mass" }
blocks.sensor = { kind = "MassSpringDamper", mass = "= heavy" }
"""
TEXT += "\n".join(f"\n[blocks.pair_{n}]\n{PART}" for n in (1, 2))
GRAPH = read_graph_text(TEXT)


def values_of(graph: Graph) -> dict[str, float]:
    return {name: value.number for name, value in graph.values.items()}


def test_what_it_resolves_to() -> None:
    k, d = 50.43e-9 * (2 * math.pi * 8000) ** 2, 2 * math.pi * 8000 * 50.43e-9 / 100
    sensor = GRAPH.blocks["sensor"]
    assert sensor.mass == 50.43e-9  # type: ignore[attr-defined]
    assert (sensor.stiffness, sensor.damping) == pytest.approx((k, d), rel=1e-15)  # type: ignore[attr-defined]
    assert (GRAPH.rate, GRAPH.duration) == (128_000, Fraction(1, 200))
    assert GRAPH.subgraphs["axis"].blocks["amplifier"] == Gain(gain=600.0, input_unit="m", output_unit="V")
    assert GRAPH.blocks["filter"].numerator == (1.0, -1.0, 0.5)  # type: ignore[attr-defined]
    assert GRAPH.subgraphs["pair_2"].blocks["sensor"].mass == 2e-6  # type: ignore[attr-defined]
    assert {value.text() for value in GRAPH.values.values()} >= {"50.43 ug", "8 kHz", "127.417 N/m"}
    assert check(GRAPH) == [] or all(problem.note for problem in check(GRAPH))


def test_it_reads_back() -> None:
    again = read_graph_text(write_graph(GRAPH))
    assert again == GRAPH
    assert write_graph(again) == write_graph(GRAPH)
    assert pickle.loads(pickle.dumps(GRAPH)) == GRAPH


def test_the_same_from_python() -> None:
    graph = Graph(
        name="values",
        rate="= 16 * f0",
        values={"mass": "50.43 ug", "f0": "8 kHz", "stiffness": "= mass * (2 * pi * f0)^2"},
        blocks={"sensor": MassSpringDamper(), "push": Constant(value="1 uN", unit="N"), "out": DisplacementReadout()},
        formulas={"sensor.mass": "= mass", "sensor.stiffness": "= stiffness"},
    )
    assert graph.blocks["sensor"].mass == 50.43e-9  # type: ignore[attr-defined]
    assert read_graph_text(write_graph(graph)) == graph


def test_what_follows_moves_with_a_value() -> None:
    heavier = GRAPH.with_parameters({"mass": "100.86 ug", "q": 200})
    before, after = GRAPH.blocks["sensor"], heavier.blocks["sensor"]
    assert after.mass == pytest.approx(2 * before.mass)  # type: ignore[attr-defined]
    assert after.stiffness == pytest.approx(2 * before.stiffness)  # type: ignore[attr-defined]
    assert after.damping == pytest.approx(before.damping)  # type: ignore[attr-defined]
    assert heavier.subgraphs["axis"].blocks["amplifier"].gain == 1200.0  # type: ignore[attr-defined]
    assert heavier.blocks["filter"].numerator[1] == -2.0  # type: ignore[attr-defined]
    assert GRAPH.with_parameters({"f0": "4 kHz"}).rate == 64_000
    assert values_of(GRAPH.with_parameters({"mass": 1e-6})) == pytest.approx(
        values_of(GRAPH) | {k: values_of(GRAPH)[k] * 1e-6 / 50.43e-9 for k in ("mass", "stiffness", "damping")}
    )


def test_a_number_takes_a_formula_away_and_a_formula_a_number() -> None:
    other = GRAPH.with_parameters({"sensor.mass": "1 mg", "readout.gain": "= q * 1 kV/m", "axis.single": 1.0})
    assert "sensor.mass" not in other.formulas
    assert "axis.single" not in other.formulas
    later = other.with_parameters({"mass": "2 mg", "q": 3})
    assert later.blocks["sensor"].mass == 1e-6  # type: ignore[attr-defined]
    assert later.blocks["readout"].gain == 3000.0  # type: ignore[attr-defined]
    assert later.subgraphs["axis"].blocks["amplifier"].gain == 2.0  # type: ignore[attr-defined]
    assert read_graph_text(write_graph(later)) == later


def test_parts_have_values_of_their_own() -> None:
    one = GRAPH.with_parameters({"pair_1.mass": "3 mg"})
    assert [one.subgraphs[f"pair_{n}"].blocks["sensor"].mass for n in (1, 2)] == [6e-6, 2e-6]  # type: ignore[attr-defined]
    assert one.with_parameters({"axis.scale": 7}).subgraphs["axis"].values["single"].number == 7.0


def test_a_misspelt_value_of_a_part_finds_the_right_one() -> None:
    with pytest.raises(ModelError) as refused:
        GRAPH.with_parameters({"pair_1.heawy": 2e-6})
    assert "did you mean heavy?" in refused.value.problems[0].hint
    text = write_graph(GRAPH) + '\n[study]\nspread = { "pair_1.heawy" = { normal = "1 %", relative = true } }\n'
    assert any("did you mean heavy?" in problem.hint for problem in problems_of(text))


def test_flat_it_is_numbers() -> None:
    flat = flatten(GRAPH).as_graph()
    assert not flat.values
    assert not flat.formulas
    assert flatten(flat).blocks == flatten(GRAPH).blocks


def test_slopes_of_what_follows() -> None:
    dependence = Dependence(GRAPH)
    mass, k = 50.43e-9, GRAPH.values["stiffness"].number
    assert dependence.slopes("mass") == pytest.approx(
        {"sensor.mass": 1.0, "sensor.stiffness": k / mass, "sensor.damping": 2 * math.pi * 80}
    )
    assert dependence.slopes("q") == pytest.approx(
        {"axis.amplifier.gain": 6.0, "filter.numerator[1]": -0.01, "sensor.damping": -2 * math.pi * 0.8 * mass}
    )


def said(old: str, new: str) -> list[str]:
    assert old in TEXT
    with pytest.raises(ModelError) as error:
        read_graph_text(TEXT.replace(old, new), "graph.toml")
    lines = TEXT.splitlines()
    return [f"{lines[p.line - 1].partition(' =')[0]}: {p.key}: {p.message}" for p in error.value.problems]


MISTAKES = {
    "a unit that does not go": (
        'mass = "50.43 ug"',
        'mass = "50.43 um"',
        [
            "mass: blocks.sensor.mass: is m, not kg",
            "stiffness: blocks.sensor.stiffness: is m/s^2, not N/m",
            "damping: blocks.sensor.damping: is m/s, not kg/s",
        ],
    ),
    "a circle, said once": (
        'mass = "50.43 ug"',
        'mass = "= stiffness"',
        ["mass: values.mass: the value depends on itself: mass -> stiffness -> mass"],
    ),
    "no quantity, and nothing of what needs it": (
        'mass = "50.43 ug"',
        "mass = true",
        ["mass: values.mass: must be a number, or a text with a unit"],
    ),
    "out of bounds": (
        'mass = "50.43 ug"\nf0',
        'mass = "-50.43 ug"\nf0',
        [
            "mass: blocks.sensor.mass: must be > 0",
            "stiffness: blocks.sensor.stiffness: must be > 0",
            "damping: blocks.sensor.damping: must be >= 0",
        ],
    ),
    "a misspelt name in a list": (
        '"= -q / 100"',
        '"= qq"',
        ["numerator: blocks.filter.numerator: there is no value or unit qq"],
    ),
    "a rate": ('"= 16 * f0"', '"= 16 * mass"', ["rate: rate: is kg, not 1/s"]),
    "a part that is not there": ('"axis.scale"', '"axes.scale"', ['"axis.scale": axes.scale: there is no block axes']),
    "a name of a unit": ("order = 2", "m = 2", ["order: values.m: the name is taken: m is a unit"]),
    "a name of a key": (
        "order = 2",
        "rate = 2",
        ["order: values.rate: the name is taken: rate is a key of graph files"],
    ),
    "a name of an export": (
        'scale = "single"',
        'single = "amplifier.gain"',
        ["values: blocks.axis.values.single: the name is taken: single is exported for amplifier.gain"],
    ),
    "an export of nothing": (
        'scale = "single"',
        'scale = "singel"',
        ["exports: blocks.axis.exports.scale: not a port or parameter"],
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_is_said_of_mistakes(mistake: str) -> None:
    old, new, messages = MISTAKES[mistake]
    assert said(old, new) == messages


def test_wires_and_probes_do_not_reach_values() -> None:
    graph = read_graph_text(TEXT.replace('"axis.y"]', '"axis.single"]'))
    assert [p.message for p in check(graph) if not p.note] == ["axis.single is a value, not a signal"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mass": "60 um"}, "mass: um is m, not kg"),
        ({"mas": 5}, "mas: there is no such value"),
        ({"sensor.mass": "= q"}, "sensor.mass: is a plain number, not kg"),
        ({"mass": "-1 kg"}, "sensor.mass: must be > 0"),
        ({"axis.singel": 2}, "axis.singel: the subgraph exports no such parameter"),
        ({"sensor.mass": "= 2 *"}, "sensor.mass: the formula ends too early"),
        ({"mass": [5]}, "values.mass: must be a number, or a text with a unit"),
        ({"mass": True}, "values.mass: must be a number, or a text with a unit"),
    ],
)
def test_what_is_said_of_changes(change: dict[str, object], message: str) -> None:
    with pytest.raises(ModelError) as error:
        GRAPH.with_parameters(change)
    assert [f"{p.key}: {p.message}" for p in error.value.problems][:1] == [message]


def test_values_may_have_any_number_and_parameters_those_of_their_block() -> None:
    adjustable = Adjustable(flatten(GRAPH))
    assert adjustable.nominal("mass") == GRAPH.values["mass"].number
    assert (adjustable.unit_of("mass"), adjustable.unit_of("sensor.mass")) == ("kg", "kg")
    assert adjustable.takes("mass", -1.0)
    assert not adjustable.takes("sensor.mass", -1.0)
    assert adjustable.moved_by("sensor.mass", {}) == {"sensor.mass": 1.0}


def test_derivatives_go_on_from_value_to_value() -> None:
    """a -> b = 3 a, c = b + 5 -> gain = 2 c a: 6 a^2 + 10 a, whose derivative at a = 4 is 58."""
    values = {"a": 4.0, "b": "= 3 * a", "c": "= b + 5"}
    blocks = {"x": Constant(), "y": Gain()}
    formulas = {"x.value": "= c", "y.gain": "= 2 * c * a"}
    graph = Graph(name="", rate=1000, blocks=blocks, wires=["x.output -> y.input"], values=values, formulas=formulas)
    adjustable = Adjustable(flatten(graph))
    assert adjustable.moved_by("a", {}) == pytest.approx({"x.value": 3.0, "y.gain": 58.0})
    assert adjustable.moved_by("b", {}) == pytest.approx({"x.value": 1.0, "y.gain": 8.0})
    assert adjustable.moved_by("a", {"a": 5.0, "b": 15.0}) == pytest.approx({"x.value": 0.0, "y.gain": 40.0})


def test_measures_of_a_part_are_not_those_of_the_whole() -> None:
    part = read_graph_text(
        'rate = "1 kHz"\nexports = { out = "a.output" }\n[values]\nsettling = "10 ms"\n[blocks.a]\nkind = "Constant"\n'
        '[measures]\nmean = { signal = "a.output", statistic = "mean", from = "= settling" }\n'
    )
    whole = Graph(name="", rate="1 kHz", blocks={"part": part}, probes=["part.out"])
    assert [step.target for step in Dependence(part).steps] == ["measures.mean.from"]
    assert Dependence(whole).steps == ()
    assert check(whole) == []


def test_an_offset_of_a_part_that_follows_from_a_value_is_written_once() -> None:
    part = Graph(name="", exports={"out": "a.output"}, blocks={"a": Constant()})
    values, formulas = {"delay": "10 us"}, {"part.clock_offset": "= delay"}
    blocks = {"part": part}
    whole = Graph(name="", rate="1 kHz", blocks=blocks, values=values, formulas=formulas, probes=["part.out"])
    text = write_graph(whole)
    assert text.count("clock_offset") == 1
    assert '"part.clock_offset" = "= delay"' in text
    assert read_graph_text(text) == whole


def test_clocks_follow_from_values_also_inside_a_part() -> None:
    part = Graph(name="", exports={"out": "a.output"}, blocks={"a": Constant()})
    values = {"delay": "10 us", "period": "20 us"}
    formulas = {"part.a.clock_offset": "= delay", "b.rate": "= period"}
    blocks = {"part": part, "b": Constant()}
    whole = Graph(name="", rate="1 kHz", blocks=blocks, values=values, formulas=formulas)
    assert flatten(whole).offsets == {"part.a": Fraction(1, 100_000)}
    assert whole.rates == {"b": 50_000}
    later = whole.with_parameters({"delay": "30 us"})
    assert flatten(later).offsets == {"part.a": Fraction(3, 100_000)}
