"""Graphs of parts for tests: a channel and an axis as files, and any graph cut into subgraphs."""

import random
from dataclasses import replace
from pathlib import Path

from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Probe, Wire
from tests.by_hand.graph_texts import said_about

CHANNEL = """\
name = "channel"
wires = ["amplifier.output -> adc.voltage"]

[exports]
voltage = "amplifier.input"
code = "adc.code"
number = "adc.number"
reference = "adc.reference"

[blocks.amplifier]
kind = "Gain"
input_unit = "V"
output_unit = "V"

[blocks.adc]
kind = "AnalogToDigital"
bits = 12
"""

AXIS = """\
name = "axis"
rate = "10 kHz"
wires = [
    "sensor.displacement -> readout.displacement",
    "readout.voltage -> channel.voltage",
]
probes = ["channel.code"]

[exports]
force = "sensor.force"
code = "channel.code"
reference = "channel.reference"

[blocks.sensor]
kind = "MassSpringDamper"

[blocks.readout]
kind = "DisplacementReadout"

[blocks.channel]
graph = "parts/channel.toml"
rate = "5 kHz"
"adc.bits" = 14
"""

THREE_AXES = """\
name = "three axes"
rate = "20 kHz"
duration = "10 ms"
wires = [
    "push.output -> axis_1.force",
    "push.output -> axis_2.force",
    "push.output -> axis_3.force",
    "axis_2.channel.number -> after.input",
]
probes = ["axis_1.code", "axis_2.code", "axis_3.channel.adc.code", "after.output"]

[blocks.push]
kind = "Constant"
value = "1 uN"
unit = "N"

[blocks.after]
kind = "Gain"

[blocks.axis]
graph = "axis.toml"
count = 3
reference = "8 V"
"""


def write_parts(folder: Path, **changes: str) -> Path:
    """The three files; a change replaces the text of one: `top`, `axis` or `channel`."""
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts" / "channel.toml").write_text(changes.get("channel", CHANNEL))
    (folder / "axis.toml").write_text(changes.get("axis", AXIS))
    top = folder / "top.toml"
    top.write_text(changes.get("top", THREE_AXES))
    return top


def cut(graph: Graph, dice: random.Random, number: int) -> Graph:
    """The graph with some of its blocks and subgraphs in a new one, exported or reached by their paths."""
    there: dict[str, Block | Graph] = {**graph.blocks, **graph.subgraphs}
    inside = {name for name in there if dice.random() < 0.5} or set(list(there)[:1])
    exports: dict[str, str] = {}

    def outer(signal: str) -> str:
        if signal.partition(".")[0] not in inside:
            return signal
        if dice.random() < 0.3:
            return f"part_{number}.{signal}"
        name = next((n for n, s in exports.items() if s == signal), f"port_{len(exports)}")
        exports[name] = signal
        return f"part_{number}.{name}"

    def moved(target: str) -> bool:
        return "." in target and target.partition(".")[0] in inside

    def within(wire: Wire) -> bool:
        return all(end.partition(".")[0] in inside for end in wire)

    wires = [Wire(outer(wire.source), outer(wire.target)) for wire in graph.wires if not within(wire)]
    probes = [Probe(outer(probe.signal), probe.every) for probe in graph.probes]
    loops = {name: replace(loop, open_at=outer(loop.open_at)) for name, loop in graph.loops.items()}
    measures = {name: m._replace(signal=outer(m.signal)) for name, m in graph.measures.items()}
    formulas = {f"part_{number}.{of}" if moved(of) else of: formula for of, formula in graph.formulas.items()}
    shown = {name: outer(signal) for name, signal in graph.exports.items()}
    part = Graph(
        name="",
        blocks={name: there[name] for name in inside},
        wires=[wire for wire in graph.wires if within(wire)],
        rates={name: rate for name, rate in graph.rates.items() if name in inside},
        exports=exports,
        place=graph.place,
    )
    return replace(
        graph,
        blocks={**{name: block for name, block in there.items() if name not in inside}, f"part_{number}": part},
        subgraphs={},
        wires=wires,
        probes=probes,
        loops=loops,
        measures=measures,
        requirements={},  # their quantities name signals in tables of many forms
        exports=shown,
        formulas=formulas,
        rates={name: rate for name, rate in graph.rates.items() if name not in inside},
    )


def said(tmp_path: Path, **changes: str) -> str:
    """What is said about the three files, with their names instead of their paths."""
    return said_about(write_parts(tmp_path, **changes)).replace(f"{tmp_path}/", "")
