"""Mistakes in graphs of parts, and the exact words that name them."""

from pathlib import Path

import pytest

from tests.by_hand.graph_texts import changed
from tests.by_hand.parts import AXIS, CHANNEL, THREE_AXES, said

MISTAKES = {
    "an export misspelt in a wire": (
        {"top": changed(THREE_AXES, "axis_2.force", "axis_2.froce")},
        """\
top.toml:6: wires: push.output -> axis_2.froce: axis_2.froce is neither an input nor a parameter
  hint:     did you mean force?""",
    ),
    "an export misspelt in a probe": (
        {"top": changed(THREE_AXES, '"axis_1.code"', '"axis_1.cdoe"')},
        """\
top.toml:10: probes: axis_1.cdoe: axis_1.cdoe is not an output
  hint:     did you mean code?""",
    ),
    "a block inside misspelt": (
        {"top": changed(THREE_AXES, "axis_2.channel.number", "axis_2.chanel.number")},
        """\
top.toml:8: wires: axis_2.chanel.number -> after.input: there is no block axis_2.chanel
  hint:     did you mean channel?""",
    ),
    "a rate that the outer graph forgets": (
        {
            "top": changed(THREE_AXES, 'rate = "20 kHz"\n', ""),
            "axis": changed(AXIS, 'rate = "10 kHz"\n', ""),
        },
        """\
top.toml:11: blocks.push: has no rate, and neither has the graph
  hint:     add rate = "50 kHz" at the top of the file, or to this block
top.toml:16: blocks.after: has no rate, and neither has the graph
  hint:     add rate = "50 kHz" at the top of the file, or to this block
top.toml:19: blocks.axis_1: blocks of it have no rate, and neither has the graph
  got:      readout
  hint:     add rate = "50 kHz" at the top of the file, or to this subgraph
top.toml:19: blocks.axis_2: blocks of it have no rate, and neither has the graph
  got:      readout
  hint:     add rate = "50 kHz" at the top of the file, or to this subgraph
top.toml:19: blocks.axis_3: blocks of it have no rate, and neither has the graph
  got:      readout
  hint:     add rate = "50 kHz" at the top of the file, or to this subgraph""",
    ),
    "an input that the outer graph forgets": (
        {"top": changed(THREE_AXES, '    "push.output -> axis_3.force",\n', "")},
        """\
top.toml:19: blocks.axis_3: the input force is not connected
  expected: a wire that carries a number in N: Force on the proof mass.
  hint:     add "push.output -> axis_3.force" to wires""",
    ),
    "an input that the inner graph forgets": (
        {"axis": changed(AXIS, '    "readout.voltage -> channel.voltage",\n', "")},
        """\
axis.toml:19: blocks.axis_1.channel: the input voltage is not connected
  expected: a wire that carries a number in V: Signal to amplify.
  hint:     add "readout.voltage -> channel.voltage" to wires, or export it: exports = { voltage = "channel.voltage" }
""".rstrip(),
    ),
    "an export of nothing": (
        {"axis": changed(AXIS, '"sensor.force"', '"sensor.froce"')},
        """\
top.toml:5: wires: push.output -> axis_1.force: axis_1.sensor.froce is neither an input nor a parameter
  hint:     did you mean force?
top.toml:6: wires: push.output -> axis_2.force: axis_2.sensor.froce is neither an input nor a parameter
  hint:     did you mean force?
top.toml:7: wires: push.output -> axis_3.force: axis_3.sensor.froce is neither an input nor a parameter
  hint:     did you mean force?
axis.toml:10: axis_1.exports.force: axis_1.sensor.froce is neither a port nor a parameter
  got:      sensor.froce
  hint:     did you mean force?""",
    ),
    "an export that is driven inside": (
        {
            "channel": changed(
                CHANNEL, 'voltage = "amplifier.input"', 'voltage = "amplifier.input"\nmore = "adc.voltage"'
            )
        },
        """\
parts/channel.toml:6: axis_1.channel.exports.more: adc.voltage is exported and driven inside
  got:      adc.voltage
  hint:     remove the export, or the wire""",
    ),
    "an export twice": (
        {"axis": changed(AXIS, 'force = "sensor.force"', 'force = "sensor.force"\npush = "sensor.force"')},
        """\
axis.toml:11: axis_1.exports.push: sensor.force is exported twice
  got:      sensor.force
  hint:     remove push: it is exported as force""",
    ),
    "an export that is no name, and one that is no signal": (
        {"axis": changed(AXIS, 'force = "sensor.force"', 'Force = "sensor.force"\ncount = "a.b"\nb = "sensor"')},
        """\
axis.toml:10: exports: not a name
  got:      'Force'
  expected: at most 64 lower-case letters and digits, words joined by single underscores
axis.toml:11: exports.count: the name is taken
  hint:     taken are graph, rate, clock_offset, count, kind
axis.toml:12: exports.b: not a port or parameter
  got:      'sensor'
  hint:     write exports = { code = "adc.code" }: a name of its own, and the port or parameter inside""",
    ),
    "exported outputs that nobody uses": (
        {"top": changed(THREE_AXES, '"axis_1.code", ', "")},
        """\
top.toml:20: note: blocks.axis_1: none of its exported outputs is used
  hint:     wire one of code, or add "axis_1.code" to probes""",
    ),
    "parameters that are not exported, ports, and keys of the top": (
        {"top": THREE_AXES + 'refrence = 3\nforce = 2\nduration = "1 s"\n"channel.adc.bist" = 3\n'},
        """\
top.toml:24: blocks.axis.refrence: the subgraph exports no such parameter
  got:      refrence
  hint:     did you mean reference? One inside: "block.parameter" = ...
top.toml:25: blocks.axis.force: the subgraph exports no such parameter
  got:      force
  hint:     force is a port: connect it in wires, as in "axis.force -> block.input", or the other way round
top.toml:26: blocks.axis.duration: the subgraph exports no such parameter
  got:      duration
  hint:     after [blocks.axis] it belongs to that block: move it above the first [blocks. ...]""",
    ),
    "a parameter inside misspelt": (
        {"top": THREE_AXES + '"channel.adc.bist" = 3\nchannel.adc.reference = "3 A"\n'},
        """\
top.toml:24: blocks.axis.channel.adc.bist: AnalogToDigital has no such parameter
  got:      bist
  hint:     did you mean bits?
top.toml:25: blocks.axis.channel.adc.reference: A is A, not m^2*kg/s^3/A
  got:      '3 A'
  expected: a number > 0, in V
  hint:     give it in V""",
    ),
    "a file misspelt": (
        {"top": changed(THREE_AXES, '"axis.toml"', '"axsi.toml"')},
        """\
top.toml:21: blocks.axis.graph: there is no file axsi.toml
  got:      'axsi.toml'
  hint:     did you mean axis.toml?""",
    ),
    "a kind and a graph": (
        {"top": changed(THREE_AXES, 'graph = "axis.toml"', 'graph = "axis.toml"\nkind = "Gain"')},
        """\
top.toml:20: blocks.axis: has a graph and kind
  hint:     a block has a kind, or a graph from a file: remove one of them""",
    ),
    "a count that is none, and one that takes a name": (
        {"top": changed(THREE_AXES, "count = 3", "count = 0") + '[blocks.a]\ngraph = "axis.toml"\ncount = 2.0\n'},
        """\
top.toml:22: blocks.axis.count: must be a count
  got:      0
  expected: an integer from 1 to 10000
top.toml:26: blocks.a.count: must be a count
  got:      2.0
  expected: an integer from 1 to 10000""",
    ),
    "a block that is not in the file of the part": (
        {"channel": changed(CHANNEL, "bits = 12", "bist = 12")},
        """\
parts/channel.toml:17: blocks.adc.bist: AnalogToDigital has no such parameter
  got:      'bist'
  hint:     did you mean bits?""",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_is_said_of_a_mistake(mistake: str, tmp_path: Path) -> None:
    changes, message = MISTAKES[mistake]
    assert said(tmp_path, **changes) == message
