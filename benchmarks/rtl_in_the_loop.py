"""A graph with compiled Verilog in the place of its digital blocks against the compiled loop alone, bit for bit.

    python benchmarks/rtl_in_the_loop.py [ticks] [graph]

The whole self-calibration where nothing else is said. Both engines go on in the same chunks: of one tick each at first,
then of 9,973, which end anywhere in a chip. Behind every chunk all registers, buffers, outputs of the hardware and rows
of the probes are compared. Ends with 1 at the first difference.
"""

import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import split
from proofmass.runner.plan.memory import Engine, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.run.engines import make_engine

CALIBRATION = library_file("self_calibration_fixed.toml")
SINGLE, CHUNK = 2_000, 9_973  # ticks that are chunks of their own; ticks of a chunk behind them


def main() -> None:
    """Print what was compared, what the hardware ended at, and the speed of both."""
    planned = plan(read_graph(Path(sys.argv[2]) if len(sys.argv) > 2 else CALIBRATION))
    ticks = int(sys.argv[1]) if len(sys.argv) > 1 else planned.ticks()
    ports = compose(planned).outputs
    outputs = {split(port.text.partition("[")[0]) for port in ports}
    engines = [make_engine(planned, n, planned.graph.seed, 0, start(planned), ticks) for n in ("compiled", "cxxrtl")]
    seconds, compared, done = [0.0, 0.0], 0, 0
    while done < ticks:
        first, done = done, min(done + (1 if done < SINGLE else CHUNK), ticks)
        states = []
        for number, engine in enumerate(engines):
            began = perf_counter()
            rows = advanced(planned, engine, first, done)
            seconds[number] += perf_counter() - began if done > SINGLE else 0.0
            memory = engine.memory()
            states.append((memory.states, memory.buffers, {node: memory.wires[node] for node in outputs}, rows))
        if states[0] != states[1]:
            print(f"{planned.graph.name}: DIFFERENT in a tick from {first:,} to {done - 1:,}")
            sys.exit(1)
        compared += 1
    print(f"{planned.graph.name}: {ticks:,} ticks equal, looked at {compared:,} times")
    for port in ports:
        name, _, entry = port.text.partition("[")
        value = states[1][2][split(name)]
        mantissa = value[int(entry.rstrip("]"))] if entry else value
        print(f"  {port.text} = {mantissa * 2.0**-port.word.fraction} {port.unit}")
    for engine, taken in zip(engines, seconds, strict=True):
        print(f"  {engine.name}: {taken:.1f} s, {(ticks - SINGLE) / taken:,.0f} ticks/s")


def advanced(planned: Plan, engine: Engine, first: int, last: int) -> list[Any]:
    """The rows of all probes from a chunk."""
    rows = [np.zeros((probe.rows(first, last), *probe.shape)) for probe in planned.probes]
    if not engine.advance(last, rows):
        print(f"{engine.name}: a number is not finite or does not fit its format, at the latest in tick {last - 1:,}")
        sys.exit(1)
    return [each.tolist() for each in rows]


if __name__ == "__main__":
    main()
