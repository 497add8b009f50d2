"""Every graph of the library that runs alone: `python benchmarks/library.py`.

Time to make it ready when it has been compiled before, time of its own run, and nanoseconds a tick.
"""

import time

from proofmass import read_graph, simulate
from proofmass.graphs.files.library import FOLDER
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.targets.native import CompiledLoop

LONGEST = 2_000_000  # ticks of a run that is timed
RUNS = 15  # of which the fastest counts, since others may share the machine


def main() -> None:
    """Run them all and print the table."""
    print(f"{'graph':34} {'blocks':>6} {'ticks':>11} {'ready':>9} {'run':>9} {'a tick':>10}")
    for path in sorted(FOLDER.rglob("*.toml")):
        if "[blocks" not in path.read_text(encoding="utf-8"):
            continue  # a study that names its graph
        graph = read_graph(path)
        if not runs_alone(flatten(graph)):
            continue
        simulate(graph, samples=1, engine="compiled")
        began = time.perf_counter()
        planned = plan(graph)
        CompiledLoop(planned, 0, memory=start(planned))
        ready, ticks = time.perf_counter() - began, min(planned.ticks(), LONGEST)
        seconds = min(simulate(graph, samples=ticks, engine="compiled").seconds for _ in range(RUNS))
        blocks, each = len(planned.blocks), seconds / ticks * 1e9
        print(f"{path.stem:34} {blocks:6} {ticks:11,} {ready * 1e3:6.0f} ms {seconds:7.3f} s {each:7.1f} ns")


if __name__ == "__main__":
    main()
