"""A graph around any blocks: each input fed by a source that suits it, each output probed."""

import math
import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from proofmass.blocks import AnalogToDigital, FixedQuantiser, ImpulseResponseEstimator, ShiftRegister
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block, param
from proofmass.blocks.declaration.instance import format_of, shape_of, unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Place

RATE = 10_000
SIZES = {"N": 3e-5, "m": 2e-7, "m/s": 1e-3}  # of signals in a sensor, where they are far from 1


class Draws(Block):
    """A linear congruential generator: random numbers that plain Python makes ten times sooner than white noise."""

    seed: int = param("1", "State at tick 0.", default=1, at_least=0)
    unit: str = param("", "Unit of the output.", default="1")
    scale: float = param("{unit}", "About what the numbers are.", default=1.0)


class Drawn(NamedTuple):
    number: int


@Draws.start
def start(p: Draws) -> Drawn:
    return Drawn(p.seed)


@Draws.output("{unit}")
def output(p: Draws, x: Drawn) -> float:
    """About zero, small numbers more often than large ones, the largest five times the scale."""
    even = x.number / 2**30 - 1.0
    return 5.0 * p.scale * even * even * even


@Draws.update
def update(p: Draws, x: Drawn) -> Drawn:
    return Drawn((1103515245 * x.number + 12345) % 2**31)


def graph_around(tested: Mapping[str, Block], folder: Path) -> Graph:
    """The blocks side by side, sources for their inputs, and probes on all their outputs.

    The inputs of one block have sources of their own; blocks share them.
    """
    blocks: dict[str, Block] = dict(tested)
    wires = []
    sources: dict[tuple[Any, ...], str] = {}
    for name, block in tested.items():
        for number, port in enumerate(type(block).inputs.values()):
            fixed = format_of(block, port.name) if port.dtype is FixedValue else None
            key = (number, port.dtype, unit_of(block, port), shape_of(block, port), fixed)
            if key not in sources:
                sources[key] = _source(blocks, wires, *key)
            wires.append(f"{sources[key]} -> {name}.{port.name}")
    return Graph(
        name=f"around {', '.join(tested)}",
        rate=RATE,
        blocks=blocks,
        wires=wires,
        probes=[f"{name}.{port}" for name, block in tested.items() for port in type(block).outputs],
        seed=7,
        place=Place(folder=str(folder)),
    )


def _source(
    blocks: dict[str, Block],
    wires: list[str],
    number: int,
    dtype: type,
    unit: str,
    shape: tuple[int, ...],
    fixed: Fixed | None,
) -> str:
    """The signal of a new source."""
    name = f"source_{len(blocks)}"
    if dtype is bool:
        blocks[name] = ShiftRegister(length=9, taps=0x110, seed=1 << 4 * number % 9)  # each independent of the others
        return f"{name}.bit"
    unit = "V" if dtype is int else unit
    seed = 123456789 * (1 + len(blocks)) % 2**31
    blocks[name] = Draws(seed=seed, unit=unit, scale=SIZES.get(unit, 1.0))
    if dtype is int:
        return _through(blocks, wires, f"{name}.output", AnalogToDigital(bits=10, reference=4.0), "voltage", "code")
    if fixed is not None:
        quantiser = FixedQuantiser(output_format=fixed, unit=unit)
        return _through(blocks, wires, f"{name}.output", quantiser, "input", "output")
    if shape:
        cells = ImpulseResponseEstimator(cells=shape[0], chips=3, unit=unit)
        vector = _through(blocks, wires, f"{name}.output", cells, "response", "impulse_response")
        wires.append(f"{_source(blocks, wires, number, bool, '1', (), None)} -> {vector.partition('.')[0]}.bit")
        return vector
    return f"{name}.output"


def _through(blocks: dict[str, Block], wires: list[str], signal: str, block: Block, entrance: str, exit_: str) -> str:
    name = f"after_{len(blocks)}"
    blocks[name] = block
    wires.append(f"{signal} -> {name}.{entrance}")
    return f"{name}.{exit_}"


def random_block(kind: type[Block], dice: random.Random, folder: Path) -> Block:
    """The block with parameters drawn about their defaults, within their bounds.

    Where all drawn at once never go together, half of them keep their defaults.
    """
    fixed = _recording(folder) if any(buffer.recorded for buffer in kind.buffers.values()) else {}
    for attempt in range(100):
        values = {n: random_value(p, dice) for n, p in kind.parameters.items() if attempt < 50 or dice.random() < 0.5}
        try:
            return kind(**(values | fixed))
        except ModelError:
            continue
    return kind(**fixed)


def random_value(parameter: Parameter, dice: random.Random) -> Any:
    """A number about the default of a parameter, within its bounds; any of its choices."""
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
