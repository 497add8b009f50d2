"""How times and memory grow with the number of blocks: `python benchmarks/growth.py [--blocks 100 1000 10000]`.

Chains, each block behind the last, and random graphs, whose blocks take any earlier output and, by delays, later ones
too. Each is measured in a process of its own: CPU seconds to make and check the graph, to plan it, to compile its loop
from nothing, to run 1,000 ticks, and the most memory that the process held. An exponent is the power of the number of
blocks by which a figure grows from one row to the next.
"""

import argparse
import json
import math
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from typing import Any

import numpy as np

from proofmass import Graph, check
from proofmass.blocks import Butterworth, Constant, Gain, Saturation, Sine, Sum, UnitDelay, WhiteNoise
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan

TICKS = 1_000
LIMITS = {"check": 3.0, "compile": 60.0}  # seconds for 10,000 blocks
PARTS = ("check", "plan", "compile", "run", "MB")
SATURATION = Saturation(lowest=-1e3, highest=1e3)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--blocks", type=int, nargs="*", default=[100, 1_000, 10_000])
    parser.add_argument("--kinds", nargs="*", choices=list(GRAPHS), default=list(GRAPHS))
    parser.add_argument("--one", action="store_true", help="measure one graph in this process, as JSON")
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(measured(arguments.kinds[0], arguments.blocks[0])))
        return
    print(f"{'graph':8} {'blocks':>7} " + " ".join(f"{part:>8}" for part in PARTS) + "   exponents")
    for name in arguments.kinds:
        before: dict[str, float] = {}
        for blocks in arguments.blocks:
            row = alone(name, blocks)
            numbers = " ".join(f"{row[part]:8.2f}" for part in PARTS)
            print(f"{name:8} {blocks:7} {numbers}   {exponents(before, row)}", flush=True)
            before = row
    print("limits for 10,000 blocks: " + ", ".join(f"{part} {limit:g} s" for part, limit in LIMITS.items()))


def alone(name: str, blocks: int) -> dict[str, float]:
    """What is measured in a fresh process, with nothing in the cache."""
    command = [sys.executable, __file__, "--one", "--kinds", name, "--blocks", str(blocks)]
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"PROOFMASS_CACHE": folder}
        done = subprocess.run(command, stdout=subprocess.PIPE, check=True, env=environment)
    row: dict[str, float] = json.loads(done.stdout)
    return row


def chain(count: int) -> tuple[dict[str, Any], list[str]]:
    """A source, and behind it gains, delays and saturations in a row."""
    kinds = Gain(gain=0.999), UnitDelay(), SATURATION
    blocks = {f"b{n}": kinds[n % 3] for n in range(1, count)}
    return {"b0": Sine()} | blocks, [f"b{n - 1}.output -> b{n}.input" for n in range(1, count)]


def random_graph(count: int) -> tuple[dict[str, Any], list[str]]:
    """Sums, gains, saturations and filters of any earlier outputs; delays of any saturation: all stays finite."""
    draw = random.Random(count)
    low_pass = Butterworth(order=1, corner_frequency=100.0)
    some: tuple[Any, ...] = Sum(), Gain(gain=0.999), SATURATION, UnitDelay(), low_pass
    kinds = [draw.choice(some) for _ in range(count)]
    kinds[:4] = [Sine(), WhiteNoise(density=1e-3), Constant(value=1.0), SATURATION]
    bounded = [n for n, kind in enumerate(kinds) if kind is SATURATION]
    wires = list[str]()
    for n in range(3, count):
        source = draw.choice(bounded) if isinstance(kinds[n], UnitDelay) else draw.randrange(n)
        ports = ("first", "second") if isinstance(kinds[n], Sum) else ("input",)
        sources = (source, draw.randrange(n))
        wires += [f"b{of}.output -> b{n}.{port}" for of, port in zip(sources, ports, strict=False)]
    return {f"b{n}": kind for n, kind in enumerate(kinds)}, wires


GRAPHS = {"chain": chain, "random": random_graph}


def measured(name: str, count: int) -> dict[str, float]:
    """CPU seconds of each part, and the most megabytes that the process held."""
    blocks, wires = GRAPHS[name](count)
    row, clock = dict[str, float](), time.process_time()

    def note(part: str) -> None:
        nonlocal clock
        now = time.process_time()
        row[part], clock = now - clock, now

    graph = Graph(name=name, rate="10 kHz", samples=TICKS, blocks=blocks, wires=wires, probes=[f"b{count - 1}.output"])
    check(graph)
    note("check")
    planned = plan(graph)
    note("plan")
    compiled = CompiledPlan(planned)
    note("compile")
    rows: list[Any] = [np.zeros((probe.rows(0, TICKS), *probe.shape), dtype=probe.dtype) for probe in planned.probes]
    finite = CompiledLoop(planned, 0, memory=start(planned), compiled=compiled).advance(TICKS, rows)
    note("run")
    assert finite, "a number was not finite"
    return row | {"MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, "blocks": count}


def exponents(before: dict[str, float], row: dict[str, float]) -> str:
    """The power of the number of blocks by which each figure grew."""
    if not before:
        return ""
    apart = math.log(row["blocks"] / before["blocks"])
    return " ".join(f"{part} {math.log(row[part] / before[part]) / apart:.2f}" for part in PARTS)


if __name__ == "__main__":
    main()
