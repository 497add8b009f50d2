"""Diagrams as text: Mermaid and DOT."""

from proofmass.blocks import (
    Constant,
    DigitalToAnalog,
    FlexurePendulum,
    Ramp,
)
from proofmass.graphs.drawing.text_forms import dot, mermaid
from proofmass.graphs.model.build import Graph


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
