"""What counting overflows costs in the compiled loop: nanoseconds a tick of two fixed-point loops, with and without.

python benchmarks/overflow_count.py
"""

import dataclasses
from typing import Any

from proofmass.blocks import Constant, FixedDifference, FixedIntegrator, FixedPID, FixedQuantiser, FixedStateSpace
from proofmass.graphs.model.build import Graph
from proofmass.runner.fixed import digital
from proofmass.runner.run.simulate import simulate

TICKS, TIMES = 2_000_000, 15


def loop(*forward: str) -> Graph:
    """A constant, quantised, less an integrator's output, through the forward blocks into the integrator."""
    chain = ["error.output", *(f"{name}.output" for name in forward)]
    inputs = ["pid.error" if name == "pid" else f"{name}.input" for name in (*forward, "integrator")]
    blocks = {"source": Constant(value=1.0), "quantiser": FixedQuantiser(), "error": FixedDifference()}
    blocks |= {"integrator": FixedIntegrator(gain=200.0, output_unit="1")}
    blocks |= {name: FixedPID() if name == "pid" else FixedStateSpace() for name in forward}
    wires = ["source.output -> quantiser.input", "quantiser.output -> error.first", "integrator.output -> error.second"]
    wires += [f"{source} -> {target}" for source, target in zip(chain, inputs, strict=True)]
    return Graph(name=" ".join(forward), rate=50_000, blocks=blocks, wires=wires)


def measure(graph: Graph, traced_by: Any) -> float:
    """Nanoseconds a tick."""
    digital.trace = traced_by
    digital._prepared.cache_clear()
    return simulate(graph, samples=TICKS, engine="compiled").seconds / TICKS * 1e9


def without_count(*arguments: Any, **options: Any) -> Any:
    """The trace, as if intervals ruled all overflows out."""
    traced = trace(*arguments, **options)
    nothing = traced.program.constant(0)
    return dataclasses.replace(traced, overflows=nothing, lost=nothing)


trace = digital.trace
for name, graph in {
    "PID controller and integrator": loop("pid"),
    "two state spaces and integrator": loop("first", "second"),
}.items():
    pairs = [(measure(graph, trace), measure(graph, without_count)) for _ in range(TIMES)]
    counted, plain = map(min, zip(*pairs, strict=True))
    print(f"{name}: {counted:.1f} ns a tick with the count, {plain:.1f} without")
