"""Margins and noise of every library graph without an option: `python -m benchmarks.answers [--noise] [GRAPH ...]`.

For each loop the verdict, gain and phase margin and the operating point that was found, or why there is none; with
`--noise` for each probe its rms. Beside it the processor time of the graph.
"""

import os
import sys
import time
from collections.abc import Iterator, Sequence

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in commands: before NumPy is loaded

from proofmass import read_graph
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import FOLDER
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.linearisation.find_loops import find_loops
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.stability import margins_or_reasons
from proofmass.runner.analysis.noise.budget import budgets_at
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

_WIDTH = 90  # of a reason


def graphs(names: Sequence[str]) -> Iterator[tuple[str, Graph]]:
    """Yield the graphs of the library that run alone, or those of some names."""
    for path in sorted(FOLDER.rglob("*.toml")):
        if (names and path.stem not in names) or "[blocks" not in path.read_text(encoding="utf-8"):
            continue  # a study that names its graph
        graph = read_graph(path)
        if runs_alone(flatten(graph)):
            yield path.stem, graph


def margins_rows(planned: Plan) -> Iterator[tuple[str, bool]]:
    """Yield a line for each loop, and whether it has an answer."""
    for name, found in margins_or_reasons(OperatingPoints(planned)).items():
        if isinstance(found, Margins):
            yield f"{name}: {repr(found).partition(': ')[2][:-1]}; {found.system.map.told or 'at the start'}", True
        else:
            yield f"{name}: {_reason(found)}", False


def noise_rows(planned: Plan) -> Iterator[tuple[str, bool]]:
    """Yield a line for each probe that is one number, and whether it has an answer; silence is one, and why so."""
    numbers = [p.node for p in planned.probes if type(planned.blocks[p.node[0]]).outputs[p.node[1]].is_number]
    outputs = list(dict.fromkeys(".".join(node) for node in numbers))
    for signal, found in zip(outputs, budgets_at(OperatingPoints(planned), outputs), strict=True):
        if isinstance(found, ModelError):
            yield f"{signal}: {_reason(found)}", "noise reaches" in found.problems[0].message
        else:
            along = next((f"; {note}" for note in found.notes if "along the run" in note), "")
            yield f"{signal}: rms {found.rms:.4g} {found.unit}{along}", True


def _reason(error: ModelError) -> str:
    return f"-- {error.problems[0].message}"[:_WIDTH]


def main(arguments: Sequence[str]) -> int:
    """Print the table and return how many graphs have no answer."""
    noise = "--noise" in arguments
    names = [name for name in arguments if name != "--noise"]
    counted = answered = 0
    for name, graph in graphs(names):
        planned = plan(graph)
        wanted = noise_blocks(planned) if noise else planned.graph.loops or find_loops(planned)
        if not wanted:
            continue
        began = time.process_time()
        rows = list((noise_rows if noise else margins_rows)(planned))
        seconds = time.process_time() - began
        counted, answered = counted + 1, answered + all(known for _, known in rows)
        for number, (line, _) in enumerate(rows):
            print(f"{'' if number else name:34} {'' if number else f'{seconds:6.2f} s':>9}  {line}", flush=True)
    print(f"{answered} of {counted} graphs answer in full")
    return counted - answered


if __name__ == "__main__":
    sys.exit(bool(main(sys.argv[1:])))
