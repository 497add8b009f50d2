"""Compiled models of Verilog against the Python functions, on vectors at random with the ends of the ranges among them.

    python benchmarks/rtl_vectors.py [vectors] [graph ...]

For each module of the digital part of the graphs: whether all outputs are equal, and clocks a second of both. Then
every angle of 20 bits through the pipelined exponential and through the one within a tick, which is proved.
"""

import random
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from proofmass.blocks.fixed_cordic_exponential import FixedCordicExponential
from proofmass.blocks.fixed_cordic_exponential_pipeline import FixedCordicExponentialPipeline
from proofmass.blocks.fixed_point import Fixed
from proofmass.blocks.fixed_quantiser import FixedQuantiser
from proofmass.blocks.sine import Sine
from proofmass.graphs.graph import Graph
from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.engine.plan import plan
from proofmass.runner.rtl.compose import compose
from proofmass.runner.rtl.cxxrtl import Model
from proofmass.runner.rtl.modules import Module
from proofmass.runner.rtl.reference import ModuleReference, as_it_runs
from proofmass.runner.rtl.verilog import module_text

LIBRARY = Path(__file__).parent.parent / "graphs" / "library"
GRAPHS = ("self_calibration_fixed.toml", "temperature_compensation_m1.toml")


def main() -> None:
    """Print a line for each module."""
    vectors = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    for path in map(Path, sys.argv[2:] or [str(LIBRARY / name) for name in GRAPHS]):
        machine = compose(plan(read_graph(path), wide=True))
        for module in machine.modules:
            print(f"{path.stem}: {compared(module, vectors)}", flush=True)
    print(exponentials())


def exponentials() -> str:
    """All angles, and by how many ticks the pipeline is late."""
    angles = np.arange(1 << 20)
    found = []
    for kind in (FixedCordicExponential, FixedCordicExponentialPipeline):
        graph = Graph(
            name="exponential",
            rate=1000,
            blocks={
                "sine": Sine(),
                "angle": FixedQuantiser(output_format=Fixed(20, 20, signed=False)),
                "exponential": kind(fraction_bits=20),
            },
            wires=["sine.output -> angle.input", "angle.output -> exponential.angle"],
            probes=["exponential.exponential"],
        )
        (module,) = compose(plan(graph)).modules
        model = Model(ModuleReference(module), module_text(module))
        found.append(model.run({"angle": np.concatenate([angles, np.zeros(64, np.int64)])}, len(angles) + 64))
    now, later = (next(iter(each.values())) for each in found)
    late = next((n for n in range(64) if np.array_equal(now[: len(angles)], later[n : n + len(angles)])), None)
    return f"pipelined exponential: {len(angles):,} angles " + (
        "DIFFERENT" if late is None else f"equal, {late} ticks late"
    )


def compared(module: Module, vectors: int) -> str:
    """Both run on the same vectors."""
    if module.pipeline.latency:
        return f"{module.name}: late by its cuts, not compared"
    reference, draws = ModuleReference(module), random.Random(1)
    inputs = {
        port.name: [drawn(draws, port.word.low, port.word.high) for _ in range(vectors)] for port in module.inputs
    }
    model = Model(reference, module_text(module))
    columns = {name: np.array(column) for name, column in inputs.items()}
    began = perf_counter()
    found = model.run(columns, vectors)
    fast = vectors / (perf_counter() - began)
    held = {register.name: register.start for register in module.registers}
    expected: dict[str, list[int]] = {port.name: [] for port in module.outputs}
    began = perf_counter()
    for t in range(vectors):
        clock = reference.clock(held | {name: column[t] for name, column in inputs.items()}, as_it_runs)
        held = {name: int(value) for name, value in clock.following.items()}
        for name, value in clock.outputs.items():
            expected[name].append(int(value))
    slow = vectors / (perf_counter() - began)
    equal = all(found[name].tolist() == column for name, column in expected.items())
    verdict = "equal" if equal else "DIFFERENT"
    return f"{module.name}: {vectors:,} vectors {verdict}; model {fast:,.0f} clocks/s, Python {slow:,.0f}"


def drawn(draws: random.Random, low: int, high: int) -> int:
    """A number of a range."""
    return draws.choice((low, high, draws.randint(low, high), draws.randint(low, high)))


if __name__ == "__main__":
    main()
