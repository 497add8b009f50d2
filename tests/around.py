"""A graph around any block: each input fed by a source that suits it, each output probed."""

import math
import random
from pathlib import Path
from typing import Any

from proofmass.blocks.analog_to_digital import AnalogToDigital
from proofmass.blocks.declare import Block
from proofmass.blocks.fixed_point import FixedValue
from proofmass.blocks.fixed_quantiser import FixedQuantiser
from proofmass.blocks.parameter import Parameter
from proofmass.blocks.problem import ModelError
from proofmass.blocks.shift_register import ShiftRegister
from proofmass.blocks.white_noise import WhiteNoise
from proofmass.graphs.graph import Graph, Place

RATE = 10_000


def graph_around(block: Block, folder: Path) -> Graph:
    """The block under the name `block`, between sources of its own and probes on all its outputs."""
    blocks: dict[str, Block] = {"block": block}
    wires = []
    for number, (name, port) in enumerate(block.inputs.items()):
        source = f"source_{number}"
        unit = block.unit_of(port)
        if port.dtype is bool:
            blocks[source] = ShiftRegister(length=9, taps=0x110, seed=1 + number)
            wires.append(f"{source}.bit -> block.{name}")
            continue
        blocks[source] = WhiteNoise(density=0.02, unit="V" if port.dtype is int else unit)
        if port.dtype is int:
            blocks[f"adc_{number}"] = AnalogToDigital(bits=10, reference=4.0)
            wires += [f"{source}.output -> adc_{number}.voltage", f"adc_{number}.code -> block.{name}"]
        elif port.dtype is FixedValue:
            blocks[f"quantiser_{number}"] = FixedQuantiser(output_format=block.format_of(name), unit=unit)
            wires += [f"{source}.output -> quantiser_{number}.input", f"quantiser_{number}.output -> block.{name}"]
        else:
            wires.append(f"{source}.output -> block.{name}")
    return Graph(
        name=f"around {type(block).__name__}",
        rate=RATE,
        blocks=blocks,
        wires=wires,
        probes=[f"block.{port}" for port in block.outputs],
        seed=7,
        place=Place(folder=str(folder)),
    )


def random_block(kind: type[Block], dice: random.Random, folder: Path) -> Block:
    """The block with parameters drawn about their defaults, within their bounds."""
    fixed = _recording(folder) if any(buffer.recorded for buffer in kind.buffers.values()) else {}
    for _ in range(100):
        values = {name: _drawn(p, dice) for name, p in kind.parameters.items()}
        try:
            return kind(**(values | fixed))
        except ModelError:
            continue
    return kind(**fixed)


def _drawn(parameter: Parameter, dice: random.Random) -> Any:
    default = parameter.default
    if parameter.kind is bool:
        return dice.random() < 0.5
    if parameter.choices:
        return dice.choice(parameter.choices)
    if parameter.kind is not float:
        return default
    value = default * math.exp(dice.gauss(0.0, 0.3)) if default else dice.uniform(-0.5, 0.5)
    for bound in (parameter.at_least, parameter.above):
        value = max(value, bound) if bound is not None else value
    for bound in (parameter.at_most, parameter.below):
        value = min(value, bound) if bound is not None else value
    return value


def _recording(folder: Path) -> dict[str, str]:
    rows = (f"{0.0037 * n!r},{math.sin(0.9 * n)!r}" for n in range(250))
    (folder / "recording.csv").write_text("\n".join(["time [s],signal", *rows]) + "\n")
    return {"file": "recording.csv"}
