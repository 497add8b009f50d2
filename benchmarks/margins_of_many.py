"""Margins of many sensors of a spread lot: `python -m benchmarks.margins_of_many [SENSORS [GRAPH]]`, 10,000 unsaid.

For each graph the processor time of all, of one, of one by the certified path, and the largest relative difference
of a figure between both over a hundred sensors, ten of those that settle first. Loops with several values of the wire
in a period take that path, and gyroscopes run for a second: they are those of a hundredth of the sensors. Of one graph
that is named all sensors are taken.
"""

import os
import sys
import time
from collections.abc import Sequence

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in commands: before NumPy is loaded

import numpy as np

from proofmass import read_graph
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.changes import changed_blocks
from proofmass.graphs.model.loops import AUTO
from proofmass.runner.analysis.margins.many import ManyMargins, margins_alone
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from tests.by_hand.lagging_loop import lagging

_SPREAD = 0.03  # of each parameter, relative
_COMPARED, _SETTLING, _PART = 100, 10, 100
_LAGGING = "a gain that comes up by a lag"
_GRAPHS = {
    "closed_loop_accelerometer": (
        "0 s",
        ("pendulum.stiffness", "pendulum.damping", "pendulum.inertia", "torquer.gain"),
    ),
    "force_balance_seismometer": ("0 s", ()),
    "closed_loop_fluxgate": ("0 s", ()),
    _LAGGING: (AUTO, ("gain.gain",)),
    "disk_resonator_gyroscope": (AUTO, ()),
    "closed_loop_gyroscope": (AUTO, ()),
}


def sensors_of(planned: Plan, names: Sequence[str], count: int) -> list[Plan]:
    """Return plans whose parameters are spread; without names, the gains of all blocks that have one."""
    dice = np.random.default_rng(1)
    names = names or [f"{name}.gain" for name, block in planned.blocks.items() if _is_number(block, "gain")]
    first = {key: getattr(planned.blocks[key.rpartition(".")[0]], key.rpartition(".")[2]) for key in names}
    draws = ({k: v * (1.0 + _SPREAD * float(dice.normal())) for k, v in first.items()} for _ in range(count))
    return [varied(planned, changed_blocks(planned.blocks, draw)) for draw in draws]


def _is_number(block: object, name: str) -> bool:
    return isinstance(getattr(block, name, None), float)


def main(arguments: Sequence[str]) -> None:
    """Print the table."""
    count, chosen = int(arguments[0]) if arguments else 10_000, arguments[1:]
    print(f"{'graph':29} {'sensors':>8} {'all':>9} {'each':>9} {'certified':>10} {'difference':>11}")
    for name, (at, names) in {name: _GRAPHS[name] for name in chosen or _GRAPHS}.items():
        planned = plan(lagging() if name == _LAGGING else read_graph(f"library:{name}"))
        number = count if names or chosen else max(1, count // _PART)
        sensors = sensors_of(planned, names, number)
        many = ManyMargins(planned, at)
        began = time.process_time()
        values = many.values(sensors)
        spent = time.process_time() - began
        some = sensors[: _SETTLING if at == AUTO else _COMPARED]
        alone = [margins_alone(sensor, at) for sensor in some]
        each = (time.process_time() - began - spent) / len(alone)
        apart = max(_difference(a, b) for a, b in zip(values, alone, strict=False))
        row = f"{spent:7.2f} s {1e3 * spent / number:6.2f} ms {1e3 * each:7.2f} ms {apart:11.1e}"
        print(f"{name:29} {number:8,} {row}", flush=True)


def _difference(one: tuple[float, ...] | ModelError, other: tuple[float, ...] | ModelError) -> float:
    if isinstance(one, ModelError) or isinstance(other, ModelError):
        return 0.0 if isinstance(one, ModelError) and isinstance(other, ModelError) else np.inf
    pairs = ((a, b) for a, b in zip(one, other, strict=True) if a != b and not (np.isnan(a) and np.isnan(b)))
    return max((abs(a - b) / abs(b) if b else np.inf for a, b in pairs), default=0.0)


if __name__ == "__main__":
    main(sys.argv[1:])
