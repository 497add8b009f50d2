"""Print what a second of each graph of the library costs: python benchmarks/gallery_times.py [--write] [NAME ...].

CPU seconds of the compiled loop over simulated seconds, the least of some runs on one core. `--write` keeps the figures
in docs/gallery_times.json, from which the pages of the gallery state them.
"""

import json
import sys
import time
from pathlib import Path

from proofmass import Graph, read_graph, simulate
from proofmass.graphs.files.gallery import exhibits
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.runner.planning.plan import plan

KEPT = Path(__file__).parents[1] / "docs" / "gallery_times.json"
RUNS, TICKS = 3, 100_000


def main() -> None:
    """Measure every graph of the library that runs alone, or those that are named."""
    costs: dict[str, float] = {}
    wanted = {name for name in sys.argv[1:] if name != "--write"}
    for item in exhibits():
        if (wanted and item.name not in wanted) or item.study or not runs_alone(flatten(read_graph(item.path))):
            continue
        graph = read_graph(item.path)
        rate = float(plan(graph).schedule.base_rate)
        simulate(graph, samples=100, engine="compiled")  # compiles
        cost = min(_seconds(graph, TICKS) for _ in range(RUNS)) * rate / TICKS
        costs[item.name] = float(f"{cost:.2g}")
        print(
            f"{item.name:34} {costs[item.name]:8.2g} s a second, {cost / rate * 1e9:7.0f} ns a tick of {rate:11,.9g} Hz"
        )
    slow = [name for name, cost in costs.items() if cost >= 1.0]
    print(f"{len(costs) - len(slow)} of {len(costs)} run faster than real time; slower: {', '.join(slow) or 'none'}")
    if "--write" in sys.argv:
        kept = json.loads(KEPT.read_text(encoding="utf-8")) if wanted else {}
        KEPT.write_text(json.dumps(kept | costs, indent=1) + "\n", encoding="utf-8")


def _seconds(graph: Graph, ticks: int) -> float:
    """CPU time of the ticks alone: that of a run less that of one of a single tick."""

    def cpu(samples: int) -> float:
        began = time.process_time()
        simulate(graph, samples=samples, engine="compiled")
        return time.process_time() - began

    return cpu(ticks) - min(cpu(1) for _ in range(2))


if __name__ == "__main__":
    main()
