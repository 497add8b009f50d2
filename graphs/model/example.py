"""A small graph that shows one kind of block: each input has a suitable source."""

from typing import Any

from proofmass.blocks import (
    AnalogToDigital,
    Comparator,
    FixedQuantiser,
    ImpulseResponseEstimator,
    Sine,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import format_of, shape_of, unit_of
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Graph as GraphValue

RATE = 10_000
SAMPLES = 1001
FREQUENCIES = (130.0, 170.0, 90.0, 210.0, 50.0, 250.0)  # Hz, different for each source
SIZES = {"N": 3e-5, "N*m": 1e-6, "m": 2e-7, "m/s": 1e-3, "rad/s": 0.1, "K": 10.0, "T": 5e-5, "W": 1e-5, "F": 1e-12}
OFFSETS = {"K": 298.15, "W": 2e-5, "F": 1e-11}  # of quantities that are never negative


def example_of(kind: type[Block], **parameters: Any) -> GraphValue:
    """Return a graph that runs: the block called `block`, sources for its inputs, probes on all its outputs."""
    block = kind(**parameters)
    graph = _Around()
    graph.blocks["block"] = block
    for port in kind.inputs.values():
        fixed = format_of(block, port.name) if port.dtype is FixedValue else None
        source = graph.source(port.dtype, unit_of(block, port), shape_of(block, port), fixed)
        graph.wires.append(f"{source} -> block.{port.name}")
    about = (kind.__doc__ or "").strip().splitlines()[0]
    probes = [f"block.{port}" for port in kind.outputs]
    return Graph(
        name=f"example of {kind.__name__}",
        description=about,
        rate=RATE,
        samples=SAMPLES,
        blocks=graph.blocks,
        wires=graph.wires,
        probes=probes,
    )


class _Around:
    """The blocks and wires of a graph in the making."""

    def __init__(self) -> None:
        self.blocks: dict[str, Block] = {}
        self.wires: list[str] = []

    def source(self, dtype: type, unit: str, shape: tuple[int, ...], fixed: Fixed | None) -> str:
        """Add a source of a signal of some type, and return its output."""
        number = sum(isinstance(block, Sine) for block in self.blocks.values())
        carried = "V" if dtype is int else "1" if dtype is bool else unit
        sine = Sine(
            frequency=FREQUENCIES[number % len(FREQUENCIES)],
            amplitude=SIZES.get(carried, 1.0),
            offset=OFFSETS.get(carried, 0.0),
            unit=carried,
        )
        signal = self._added("sine", sine, "output")
        if dtype is bool:
            return self._through(signal, "comparator", Comparator(), "input", "on")
        if dtype is int:
            return self._through(signal, "converter", AnalogToDigital(bits=10, reference=4.0), "voltage", "code")
        if fixed is not None:
            return self._through(signal, "quantiser", FixedQuantiser(output_format=fixed, unit=unit), "input", "output")
        if shape:
            cells = ImpulseResponseEstimator(cells=shape[0], chips=3, unit=unit)
            vector = self._through(signal, "cells", cells, "response", "impulse_response")
            self.wires.append(f"{self.source(bool, '1', (), None)} -> {vector.partition('.')[0]}.bit")
            return vector
        return signal

    def _added(self, name: str, block: Block, port: str) -> str:
        number = sum(other.startswith(name) for other in self.blocks)
        called = f"{name}_{number + 1}" if number else name
        self.blocks[called] = block
        return f"{called}.{port}"

    def _through(self, signal: str, name: str, block: Block, entrance: str, port: str) -> str:
        end = self._added(name, block, port)
        self.wires.append(f"{signal} -> {end.partition('.')[0]}.{entrance}")
        return end
