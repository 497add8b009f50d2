"""A graph around any blocks: each input fed by a source that suits it, each output probed."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from proofmass.blocks import AnalogToDigital, FixedQuantiser, ImpulseResponseEstimator, ShiftRegister
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import format_of, shape_of, unit_of
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Place
from proofmass.runner.contract.sources import Draws, HostileIntegers, HostileNumbers

RATE = 10_000
SIZES = {"N": 3e-5, "m": 2e-7, "m/s": 1e-3}  # of signals in a sensor, where they are far from 1


def graph_around(tested: Mapping[str, Block], folder: Path, hostile: bool = False, scale: float = 1.0) -> Graph:
    """The blocks side by side, sources for their inputs, and probes on all their outputs.

    The inputs of one block have sources of their own; blocks share them. With `hostile` there are
    numbers at the edges of arithmetic among them; `scale` makes the ordinary ones smaller.
    """
    blocks: dict[str, Block] = dict(tested)
    wires: list[str] = []
    sources: dict[tuple[Any, ...], str] = {}
    for name, block in tested.items():
        for number, port in enumerate(type(block).inputs.values()):
            fixed = format_of(block, port.name) if port.dtype is FixedValue else None
            key = (number, port.dtype, unit_of(block, port), shape_of(block, port), fixed)
            if key not in sources:
                sources[key] = _source(blocks, wires, (hostile, scale), *key)
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
    how: tuple[bool, float],
    number: int,
    dtype: type,
    unit: str,
    shape: tuple[int, ...],
    fixed: Fixed | None,
) -> str:
    """The signal of a new source."""
    name, (hostile, scale) = f"source_{len(blocks)}", how
    if dtype is bool:
        blocks[name] = ShiftRegister(length=9, taps=0x110, seed=1 << 4 * number % 9)  # each independent of the others
        return f"{name}.bit"
    seed = 123456789 * (1 + len(blocks)) % 2**31
    if hostile and dtype is int:
        blocks[name] = HostileIntegers(seed=seed, unit=unit)
        return f"{name}.integer"
    unit = "V" if dtype is int else unit
    size = scale * SIZES.get(unit, 1.0)
    if hostile and fixed is not None:
        size = float(fixed.highest) * 2.0**-fixed.fraction
    if hostile and fixed is None:
        blocks[name] = HostileNumbers(seed=seed, unit=unit, scale=size)
    else:
        blocks[name] = Draws(seed=seed, unit=unit, scale=size)
    signal = f"{name}.{next(iter(type(blocks[name]).outputs))}"
    if dtype is int:
        return _through(blocks, wires, signal, AnalogToDigital(bits=10, reference=4.0), "voltage", "code")
    if fixed is not None:
        quantiser = FixedQuantiser(output_format=fixed, unit=unit)
        return _through(blocks, wires, signal, quantiser, "input", "output")
    if shape:
        cells = ImpulseResponseEstimator(cells=shape[0], chips=3, unit=unit)
        vector = _through(blocks, wires, signal, cells, "response", "impulse_response")
        bit = _source(blocks, wires, how, number, bool, "1", (), None)
        wires.append(f"{bit} -> {vector.partition('.')[0]}.bit")
        return vector
    return signal


def _through(blocks: dict[str, Block], wires: list[str], signal: str, block: Block, entrance: str, exit_: str) -> str:
    name = f"after_{len(blocks)}"
    blocks[name] = block
    wires.append(f"{signal} -> {name}.{entrance}")
    return f"{name}.{exit_}"
