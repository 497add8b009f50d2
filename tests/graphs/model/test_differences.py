"""Differences of graphs: fifty mutations, each named with its key and nothing else; and what makes no difference."""

from pathlib import Path

import pytest

from proofmass.blocks import Constant, Sum
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.differences import GraphDifference, differences
from proofmass.graphs.model.flatten import flatten

TEXT = """\
name = "a loop"
description = "A mass held in its place."
rate = "100 kHz"
duration = "50 ms"
seed = 3
wires = [
    "push.output -> forces.first",
    "actuator.output -> forces.second",
    "forces.output -> sensor.force",
    "sensor.displacement -> readout.displacement",
    "readout.voltage -> noisy.first",
    "noise.output -> noisy.second",
    "noisy.output -> adc.voltage",
    "adc.number -> controller.error",
    "controller.output -> actuator.input",
    "adc.number -> monitor.input",
    "wander.output -> adc.reference",
]
probes = ["adc.code", { signal = "controller.output", every = 10 }]

[values]
mass = "1 mg"
resonance = "200 Hz"
stiffness = "= mass * (2 * pi * resonance)^2"
gain = "0.2 uN"

[measures]
bias = { signal = "controller.output", statistic = "mean", from = "10 ms" }
noise = { signal = "adc.number", statistic = "std" }

[integration]
accuracy = 1e-8

[exports]
code = "adc.code"

[loops.main]
open_at = "controller.output"
phase_margin = "30 deg"
gain_margin = "6 dB"

[blocks]
push = { kind = "Sine", amplitude = "1 uN", frequency = "5 Hz", unit = "N" }
forces = { kind = "Sum", unit = "N" }
readout = { kind = "DisplacementReadout", gain = "2 V/um" }
noise = { kind = "WhiteNoise", density = "1 uV/sqrt(Hz)", unit = "V" }
noisy = { kind = "Sum", unit = "V" }
adc = { kind = "AnalogToDigital", bits = 16 }
wander = { kind = "Ramp", offset = "5 V", slope = "1 mV/s", unit = "V" }
actuator = { kind = "Gain", gain = -1, input_unit = "N", output_unit = "N" }
controller = { kind = "PID", rate = "10 kHz", proportional = "= gain", derivative_gain = 0, output_unit = "N" }

[blocks.sensor]
kind = "MassSpringDamper"
mass = "= mass"
stiffness = "= stiffness"
damping = "3e-4 kg/s"

[blocks.monitor]
values = { corner = "100 Hz" }
exports = { input = "low.input" }
blocks.low = { kind = "LowPass", corner_frequency = "= corner", input_unit = "1", output_unit = "1" }
"""
GRAPH = read_graph_text(TEXT)

MUTATIONS: list[tuple[str, str, list[str]]] = [
    ('"a loop"', '"another loop"', ["changed name"]),
    ("in its place", "in place", ["changed description"]),
    ('description = "A mass held in its place."\n', "", ["removed description"]),
    ('rate = "100 kHz"', 'rate = "200 kHz"', ["changed rate"]),
    ('"50 ms"', '"51 ms"', ["changed duration"]),
    ('duration = "50 ms"', "samples = 5001", ["changed duration"]),
    ('duration = "50 ms"\n', "", ["removed duration"]),
    ("seed = 3", "seed = 4", ["changed seed"]),
    ("1 mg", "2 mg",
     ["changed values.mass", "changed blocks.sensor.mass < mass", "changed blocks.sensor.stiffness < mass"]),
    ("200 Hz", "201 Hz", ["changed values.resonance", "changed blocks.sensor.stiffness < resonance"]),
    ('resonance)^2"', 'resonance)^2 * 1"', ["changed values.stiffness"]),
    ('resonance)^2"', 'resonance)^2 * 2"', ["changed values.stiffness", "changed blocks.sensor.stiffness < stiffness"]),
    ('gain = "0.2 uN"\n', 'gain = "0.2 uN"\nspare = 1\n', ["added values.spare"]),
    ('mass = "= mass"', 'mass = "1 mg"', ["changed blocks.sensor.mass"]),
    ('mass = "= mass"', 'mass = "= mass / 1"', ["changed blocks.sensor.mass"]),
    ('mass = "= mass"', 'mass = "3 mg"', ["changed blocks.sensor.mass"]),
    ('"100 Hz"', '"90 Hz"',
     ["changed values.monitor.corner", "changed blocks.monitor.low.corner_frequency < monitor.corner"]),
    ("push.output -> forces.first", "noise.output -> forces.first", ["changed wires: forces.first"]),
    ('    "wander.output -> adc.reference",\n', "", ["removed wires: adc.reference"]),
    ('"wander.output -> adc.reference",', '"wander.output -> adc.reference",\n    "push.output -> forces.third",',
     ["added wires: forces.third"]),
    ("adc.number -> monitor.input", "adc.number -> readout.gain",
     ["removed wires: monitor.low.input", "added wires: readout.gain"]),
    ('"adc.code", {', "{", ["removed probes: adc.code"]),
    ("every = 10", "every = 5", ["changed probes: controller.output"]),
    (", every = 10 }", " }", ["changed probes: controller.output"]),
    ('probes = ["adc.code"', 'probes = ["adc.number", "adc.code"', ["added probes: adc.number"]),
    ('"mean"', '"rms"', ["changed measures.bias"]),
    ('"10 ms"', '"20 ms"', ["changed measures.bias"]),
    (', from = "10 ms"', "", ["changed measures.bias"]),
    ('noise = { signal = "adc.number"', 'noise = { signal = "adc.code"', ["changed measures.noise"]),
    ('noise = { signal = "adc.number", statistic = "std" }\n', "", ["removed measures.noise"]),
    ('noise = { signal', 'error = { signal', ["added measures.error", "removed measures.noise"]),
    ('statistic = "std"', 'statistic = "percentile", percent = 99', ["changed measures.noise"]),
    ("1e-8", "1e-7", ["changed integration.accuracy"]),
    ("1e-8", '1e-8\nmethod = "radau"', ["added integration.method"]),
    ("[integration]\naccuracy = 1e-8\n", "", ["removed integration.accuracy"]),
    ('code = "adc.code"\n', 'code = "adc.number"\n', ["changed exports.code"]),
    ('code = "adc.code"\n', 'output = "adc.code"\n', ["removed exports.code", "added exports.output"]),
    ('open_at = "controller.output"', 'open_at = "actuator.output"', ["changed loops.main.open_at"]),
    ('"30 deg"', '"45 deg"', ["changed loops.main.phase_margin"]),
    ('gain_margin = "6 dB"\n', "", ["removed loops.main.gain_margin"]),
    ('gain_margin = "6 dB"', 'delay_margin = "1 us"',
     ["added loops.main.delay_margin", "removed loops.main.gain_margin"]),
    ("bits = 16", "bits = 12", ["changed blocks.adc.bits"]),
    ('"1 uN", frequency', '"2 uN", frequency', ["changed blocks.push.amplitude"]),
    ("5 Hz", "6 Hz", ["changed blocks.push.frequency"]),
    ("gain = -1,", "gain = 1,", ["changed blocks.actuator.gain"]),
    ('rate = "10 kHz"', 'rate = "20 kHz"', ["changed blocks.controller.rate"]),
    ('rate = "10 kHz", ', "", ["removed blocks.controller.rate"]),
    ('kind = "Ramp", offset = "5 V", slope = "1 mV/s"', 'kind = "Constant", value = "5 V"',
     ["changed blocks.wander.kind"]),
    ("1 uV/sqrt(Hz)", "2 uV/sqrt(Hz)", ["changed blocks.noise.density"]),
    ("derivative_gain = 0", "derivative_gain = 0, limited = true", ["changed blocks.controller.limited"]),
    ('damping = "3e-4 kg/s"', 'damping = "2e-4 kg/s"', ["changed blocks.sensor.damping"]),
    ("wander", "drift", ["renamed blocks"]),
    ("monitor", "watch", ["renamed blocks"]),
    ("forces = {", 'idle = { kind = "Constant" }\nforces = {', ["added blocks.idle"]),
]  # fmt: skip


def said(difference: GraphDifference) -> str:
    return f"{difference.what} {difference.key}" + (f" < {difference.follows}" if difference.follows else "")


def test_there_are_fifty() -> None:
    assert len(MUTATIONS) >= 50


@pytest.mark.parametrize(("old", "new", "expected"), MUTATIONS, ids=[f"{new[:30]}" for _, new, _ in MUTATIONS])
def test_a_mutation_is_named(old: str, new: str, expected: list[str]) -> None:
    assert old in TEXT
    assert [said(d) for d in differences(GRAPH, read_graph_text(TEXT.replace(old, new)))] == expected


@pytest.mark.friendly(13, "differences have what was written")
def test_what_was_there_and_what_is_there_now() -> None:
    changed = read_graph_text(TEXT.replace("2 V/um", "3 V/um").replace('mass = "= mass"', 'mass = "2 mg"'))
    assert differences(GRAPH, changed) == [
        GraphDifference("blocks.readout.gain", "2 V/um", "3 V/um"),
        GraphDifference("blocks.sensor.mass", "= mass (1e-06 kg)", "2 mg"),
    ]
    removed = read_graph_text(
        TEXT.replace('actuator = { kind = "Gain"', 'act = { kind = "Gain"').replace("gain = -1", "gain = 9")
    )
    assert differences(GRAPH, removed)[:2] == [
        GraphDifference("blocks.act", "", "Gain: gain = 9.0, input_unit = N, output_unit = N"),
        GraphDifference("blocks.actuator", "Gain: gain = -1.0, input_unit = N, output_unit = N", ""),
    ]


@pytest.mark.defect("S859", before="statistic std, until None, unit ", after="what was written alone")
def test_a_measure_in_one_line_has_what_was_written() -> None:
    measures = 'bias = { signal = "controller.output", statistic = "mean", from = "1 s" }\n'
    _, _, rest = TEXT.partition("[integration]")
    changed = read_graph_text(f"{TEXT.partition('[measures]')[0]}[measures]\n{measures}\n[integration]{rest}")
    assert [d for d in differences(GRAPH, changed) if d.key.startswith("measures")] == [
        GraphDifference(
            "measures.bias",
            "signal controller.output, statistic mean, from 10 ms",
            "signal controller.output, statistic mean, from 1 s",
        ),
        GraphDifference("measures.noise", "signal adc.number, statistic std", ""),
    ]


def test_what_makes_no_difference() -> None:
    assert differences(GRAPH, read_graph_text(write_graph(GRAPH))) == []
    lines = TEXT.splitlines()
    wires = lines[6:17]
    again = "\n".join([*lines[:6], *reversed(wires), *lines[17:]])
    again = again.replace("1 mg", "1000 ug").replace('"100 kHz"', '"10 us"').replace("2 V/um", "2e6 V/m")
    assert differences(GRAPH, read_graph_text(f"# a comment\n{again}")) == []
    flat = flatten(GRAPH).as_graph()
    assert {d.what for d in differences(GRAPH, flat)} <= {"removed", "changed"}  # the values alone
    assert not [d for d in differences(GRAPH, flat) if not d.key.startswith(("values", "blocks"))]


def test_blocks_that_look_alike_bear_another_name_only_where_its_end_says_which() -> None:
    def graph(first: str, second: str) -> Graph:
        wires = [f"{first}.output -> sum.first", f"{second}.output -> sum.second"]
        return Graph(name="", rate=1, blocks={first: Constant(), second: Constant(), "sum": Sum()}, wires=wires)

    old = graph("one", "other")
    into_a_part = differences(old, graph("part.one", "part.other"))
    assert [(d.key, d.before, d.after) for d in into_a_part] == [
        ("blocks", "one", "part.one"),
        ("blocks", "other", "part.other"),
    ]
    blocks = [d.key for d in differences(old, graph("left", "right")) if d.key.startswith("blocks")]
    assert blocks == ["blocks.left", "blocks.one", "blocks.other", "blocks.right"]


FOLLOWING = """
rate = "= 16 * pace"
duration = "= 800 / pace"
wires = ["source.output -> gain.input"]
values.pace = "1 kHz"
measures.mean = { signal = "gain.output", statistic = "mean", from = "= 10 / pace" }
blocks.source = { kind = "Constant" }
blocks.gain = { kind = "Gain", rate = "= 8 * pace", clock_offset = "= 0.0625 / pace" }
"""
IN_NUMBERS = {
    "= 16 * pace": ("16 kHz", "formulas.rate"),
    "= 800 / pace": ("800 ms", "formulas.duration"),
    "= 10 / pace": ("10 ms", "formulas.measures.mean.from"),
    "= 8 * pace": ("8 kHz", "formulas.gain.rate"),
    "= 0.0625 / pace": ("62.5 us", "formulas.gain.clock_offset"),
}


@pytest.mark.defect("S993", before="they mean the same, but not at another pace", after="the formula, by its key")
@pytest.mark.parametrize("formula", IN_NUMBERS)
def test_a_formula_that_became_a_number_is_named(formula: str) -> None:
    number, key = IN_NUMBERS[formula]
    found = differences(read_graph_text(FOLLOWING), read_graph_text(FOLLOWING.replace(formula, number)))
    assert found == [GraphDifference(key, formula, "")]


@pytest.mark.defect(
    "S1005", before="two changes where one formula has changed, and `follows` at some", after="one each"
)
@pytest.mark.parametrize(
    ("formula", "other", "found"),
    [
        ("= 16 * pace", "= 32 * pace", ("rate", "16 kHz (= 16 * pace)", "32 kHz (= 32 * pace)")),
        ("= 800 / pace", "= 900 / pace", ("duration", "800 ms (= 800 / pace)", "900 ms (= 900 / pace)")),
        ("= 8 * pace", "4 kHz", ("blocks.gain.rate", "8 kHz (= 8 * pace)", "4 kHz")),
        ("= 0.0625 / pace", "0 s", ("blocks.gain.clock_offset", "62.5 us (= 0.0625 / pace)", "")),
    ],
)
def test_a_formula_of_a_rate_or_a_time_stands_beside_its_number(
    formula: str, other: str, found: tuple[str, str, str]
) -> None:
    changed = FOLLOWING.replace(formula, other)
    assert differences(read_graph_text(FOLLOWING), read_graph_text(changed)) == [GraphDifference(*found)]


def test_a_formula_of_the_rate_of_a_part_stands_at_its_blocks(tmp_path: Path) -> None:
    """A block with a rate of its own does not follow; what does follow from a value says so."""
    inner = 'exports.input = "a.input"\nblocks.a.kind = "Gain"\nblocks.b = { kind = "Constant", rate = "2 kHz" }\n'
    (tmp_path / "part.toml").write_text(inner)

    def outer(rate: str, pace: str = "1 kHz") -> Graph:
        path = tmp_path / "outer.toml"
        part = f'blocks.part = {{ graph = "part.toml", rate = "{rate}" }}'
        path.write_text(f'rate = "16 kHz"\nvalues.pace = "{pace}"\n{part}\n')
        return read_graph(path)

    assert differences(outer("= 8 * pace"), outer("= 4 * pace")) == [
        GraphDifference("blocks.part.a.rate", "8 kHz (= 8 * pace)", "4 kHz (= 4 * pace)")
    ]
    assert differences(outer("= 8 * pace"), outer("= 8 * pace", "2 kHz"))[1:] == [
        GraphDifference("blocks.part.a.rate", "8 kHz", "", "pace")
    ]


MEAN = "signal gain.output, statistic mean, from "


@pytest.mark.defect("S1043", before="two changes where one formula of a measure has changed", after="one")
@pytest.mark.parametrize(("new", "after"), [("= 20 / pace", "20 ms (= 20 / pace)"), ("20 ms", "20 ms")])
def test_a_formula_of_a_measure_stands_beside_its_number(new: str, after: str) -> None:
    found = differences(read_graph_text(FOLLOWING), read_graph_text(FOLLOWING.replace("= 10 / pace", new)))
    assert found == [GraphDifference("measures.mean", f"{MEAN}10 ms (= 10 / pace)", MEAN + after)]


def test_a_measure_says_which_value_it_follows() -> None:
    (found,) = (
        difference
        for difference in differences(read_graph_text(FOLLOWING), read_graph_text(FOLLOWING.replace('"1 k', '"2 k')))
        if difference.key.startswith("measures")
    )
    assert found == GraphDifference("measures.mean", f"{MEAN}10 ms", f"{MEAN}5 ms", "pace")


def test_what_is_gone_is_gone_with_its_formulas() -> None:
    less = "\n".join(line for line in FOLLOWING.splitlines() if not line.startswith("measures"))
    gained = FOLLOWING.replace('"Gain", rate', '"Gain", gain = "= pace / 1 kHz", rate')
    alone = "\n".join(line for line in gained.splitlines() if not line.startswith(("wires", "measures", "blocks.gain")))
    assert differences(read_graph_text(FOLLOWING), read_graph_text(less)) == [
        GraphDifference("measures.mean", f"{MEAN}10 ms (= 10 / pace)")
    ]
    keys = [difference.key for difference in differences(read_graph_text(gained), read_graph_text(alone))]
    assert "blocks.gain" in keys
    assert "formulas.gain.gain" not in keys


@pytest.mark.defect("S992", before="alike to six digits: they mean the same", after="all digits count")
def test_a_required_margin_differs_by_its_last_digit() -> None:
    required = TEXT.replace('open_at = "controller.output"', 'open_at = "controller.output"\ndelay_margin = "1 ms"')
    assert required != TEXT
    changed = required.replace('"1 ms"', '"1.0000001 ms"')
    (found,) = differences(read_graph_text(required), read_graph_text(changed))
    assert found == GraphDifference("loops.main.delay_margin", "0.001 s", "0.0010000001 s")
