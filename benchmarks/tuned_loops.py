"""Two loops tuned to 60 degrees with the least noise, beside grids of controllers found in lanes.

python benchmarks/tuned_loops.py [quartz | gyroscope] [POINTS]

The loops are the PID of the closed-loop quartz accelerometer and the rebalance loop of the closed-loop gyroscope. The
grid knows nothing of derivatives and of budgets. Its margins come from a dense sweep: L is linear in the gains of a
PID, so that some open-loop responses give those of all points. Its noise is the standard deviation of the output of
runs side by side in lanes. The quietest feasible points of the grid are then compared with the tuned one by the same
budget. A further goal, a limit that both cannot keep, shows how a conflict is answered.
"""

import itertools
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import proofmass
from proofmass import Graph, Tuned, tune
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.quantities import read_quantity_of
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import one_loop
from proofmass.runner.design.quantities.evaluator import Evaluator
from proofmass.runner.design.tune.text import tuned_text
from proofmass.runner.planning.plan import plan

QUIETEST = 10  # points of the grid that are compared by the budget
POINTS = 10_000
_SWEEP = 4000  # frequencies
_ABREAST = 512  # points whose responses are swept together
Points = np.ndarray[Any, np.dtype[np.float64]]

_NOISY = """
[blocks.hiss]
kind = "WhiteNoise"
density = "5 uV/sqrt(Hz)"
unit = "V"

[blocks.seen]
kind = "Sum"
unit = "V"
"""


@dataclass(frozen=True)
class Case:
    """A loop, the gains of its controller with their bounds, and what is wanted."""

    graph: Graph
    loop: str
    gains: Mapping[str, tuple[float, float]]
    output: str  # whose noise counts
    bandwidth: float  # Hz, at least
    at: str  # time at which it is linearised
    measure: str  # the noise of a run

    @property
    def goals(self) -> dict[str, dict[str, Any]]:
        """Return 60 degrees, the bandwidth, and the least noise."""
        return {
            "phase": {"loop": self.loop, "figure": "phase_margin", "at_least": "60 deg"},
            "wide": {"loop": self.loop, "figure": "bandwidth", "at_least": self.bandwidth},
            "quiet": {"noise": self.output, "minimise": True},
        }

    @property
    def free(self) -> dict[str, dict[str, float]]:
        """Return the bounds of the gains."""
        return {name: {"at_least": low, "at_most": high} for name, (low, high) in self.gains.items()}

    def tuned(self, samples: int, starts: int, more: Mapping[str, Any] | None = None) -> Tuned:
        """Return the tuned loop; `more` are further goals."""
        goals = {**self.goals, **(more or {})}
        return tune(self.graph, free=self.free, goals=goals, at=self.at, samples=samples, starts=starts)


def quartz() -> Case:
    """Return the quartz accelerometer at rest with the noise of an amplifier before its converter."""
    graph = proofmass.read_graph("library:closed_loop_accelerometer")
    text = proofmass.write_graph(graph).replace(
        '"pickoff.output -> adc.voltage"',
        '"pickoff.output -> seen.first", "hiss.output -> seen.second", "seen.output -> adc.voltage"',
    )
    noise = '[measures]\nnoise = { signal = "dac.code", statistic = "std", from = "0.02 s" }\n\n[loops.main]'
    text = text.replace("[loops.main]", noise) + _NOISY
    resting = {"acceleration.amplitude": 0.0, "acceleration.offset": 0.0, "reference.slope": 0.0}
    return Case(
        read_graph_text(text.replace("samples = 1000000", "samples = 6000")).with_parameters(resting),
        "main",
        {"pid.proportional": (0.02, 0.8), "pid.integral": (1.0, 400.0), "pid.derivative_gain": (1e-6, 2e-4)},
        "dac.code",
        400.0,
        "",
        "noise",
    )


def gyroscope() -> Case:
    """Return the gyroscope without rotation, at the time at which its drive has settled."""
    text = proofmass.write_graph(proofmass.read_graph("library:closed_loop_gyroscope"))
    noise = '[measures]\nnoise = { signal = "rate.output", statistic = "std", from = "0.2 s" }\n'
    graph = read_graph_text(text.replace("[measures]\n", noise)).with_parameters({"rotation.amplitude": 0.0})
    return Case(
        graph,
        "rate",
        {"rate_controller.proportional": (-16.0, -1.0), "rate_controller.integral": (-12000.0, -100.0)},
        "rate.output",
        120.0,
        "0.15 s",
        "noise",
    )


CASES = {"quartz": quartz, "gyroscope": gyroscope}


def grid(case: Case, points: int) -> Points:
    """Return about so many points, even on the logarithmic axes of the gains."""
    each = round(points ** (1.0 / len(case.gains)))
    axes = [np.sign(low) * np.geomspace(abs(low), abs(high), each) for low, high in case.gains.values()]
    return np.array(list(itertools.product(*axes)))


def feasible(case: Case, gains: Points) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which points keep phase margin and bandwidth, by a sweep over frequencies."""
    frequencies = np.geomspace(0.05, 0.4999 * _rate(case), _SWEEP)
    parts = _parts(case, frequencies)
    kept = [_kept(case, rows @ parts, frequencies) for rows in np.array_split(gains, -(-len(gains) // _ABREAST))]
    return np.concatenate(kept)


def _rate(case: Case) -> float:
    planned = plan(case.graph)
    return 1.0 / OperatingPoints(planned, case.at or 0.0).loop(one_loop(planned, case.loop)[1]).sample


def _parts(case: Case, frequencies: Points) -> np.ndarray[Any, np.dtype[np.complex128]]:
    """Return the open loop of each gain alone, for a gain of one."""
    names, rows = list(case.gains), []
    for name in names:
        alone = case.graph.with_parameters({n: case.gains[n][1] if n == name else 0.0 for n in names})
        planned = plan(alone)
        system = OperatingPoints(planned, case.at or 0.0).loop(one_loop(planned, case.loop)[1])
        rows.append(system.response(2.0 * np.pi * frequencies) / case.gains[name][1])
    return np.array(rows)


def _kept(case: Case, loop: Any, frequencies: Points) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which of some open loops, a row each, keep 60 degrees at every crossover, and the bandwidth.

    A margin lies between two frequencies of the sweep: the smaller of both sides counts, and the lower frequency.
    """
    over = np.abs(loop) >= 1.0
    crossing = over[:, 1:] != over[:, :-1]
    lag = np.abs(np.degrees(np.angle(-loop)))
    least = np.where(crossing, np.minimum(lag[:, 1:], lag[:, :-1]), 180.0).min(axis=1)
    closed = np.abs(loop / (1.0 + loop))
    fallen = closed < np.sqrt(0.5) * closed[:, :1]
    band = frequencies[np.maximum(np.argmax(fallen, axis=1) - 1, 0)]
    wide = ~fallen.any(axis=1) | (band >= case.bandwidth)
    stable = np.abs(1.0 + loop).min(axis=1) > 0.3  # of 60 degrees at all crossovers; far from encirclements
    return np.asarray((least >= 60.0) & wide & stable & crossing.any(axis=1))


def noise_of_runs(case: Case, gains: Points) -> Points:
    """Return the noise of a run at each point, side by side in lanes, with the same seed."""
    flat = flatten(case.graph)
    evaluator = Evaluator(case.graph, {"noise": read_quantity_of({"measure": case.measure}, flat)}, "", {})
    rows = [dict(zip(case.gains, row, strict=True)) for row in gains.tolist()]
    column = evaluator.measured_names.index(case.measure)
    return np.asarray(evaluator.measure(rows)[:, column])


def compared(case: Case, points: int, samples: int = 32, starts: int = 2) -> tuple[Tuned, float, float, int]:
    """Return the tuned loop, its noise, the least noise of the grid by the same budget, and the feasible points."""
    tuned = case.tuned(samples, starts)
    gains = grid(case, points)
    kept = gains[feasible(case, gains)]
    quietest = kept[np.argsort(noise_of_runs(case, kept))[:QUIETEST]]
    quantity = read_quantity_of({"noise": case.output}, flatten(case.graph))
    evaluator, found = Evaluator(case.graph, {"quiet": quantity}, case.at, {}), []
    for row in quietest.tolist():
        reading = evaluator.readings(dict(zip(case.gains, row, strict=True)), slopes=False)["quiet"]
        found += [] if reading is None else [reading.value]
    return tuned, float(tuned.goals[2].after or np.nan), min(found), len(kept)


def main(names: list[str], points: int) -> None:
    """Print a comparison for each loop, and how a conflict is answered."""
    for name in names:
        case, began = CASES[name](), time.process_time()
        tuned, noise, of_grid, count = compared(case, points)
        print(f"{name}: {points:,} points of the grid, {count:,} keep the goals")
        print(tuned_text(tuned))
        print(f"noise tuned {noise:.6g}, quietest of the grid {of_grid:.6g}: {noise / of_grid:.6f} of it")
        conflict = {"still": {"noise": case.output, "at_most": 0.5 * noise}}
        answer = case.tuned(32, 2, conflict)
        print("with half of this noise as a limit:")
        print(tuned_text(answer))
        print(f"{time.process_time() - began:.0f} s of CPU time\n")


if __name__ == "__main__":
    chosen = [argument for argument in sys.argv[1:] if argument in CASES] or list(CASES)
    main(chosen, next((int(argument) for argument in sys.argv[1:] if argument.isdigit()), POINTS))
