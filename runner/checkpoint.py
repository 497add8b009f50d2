"""An interrupted run on disk: what moves, and the rows recorded so far, to go on from to the same bits."""

import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.problem import ModelError, Problem
from proofmass.runner.memory import Memory
from proofmass.runner.plan import Plan
from proofmass.runner.provenance import graph_hash
from proofmass.runner.result import Result

FILE = "checkpoint.json"


def save_checkpoint(result: Result, folder: Path) -> None:
    """Write the memory of an interrupted run and its traces as `.npy` files into the folder."""
    memory = result.memory
    if memory is None:
        raise ValueError("the run was not interrupted")
    folder.mkdir(parents=True, exist_ok=True)
    for trace in result.traces.values():
        path = folder / f"{trace.signal}.npy"
        if not isinstance(trace.values, np.memmap):
            np.save(path, trace.values)
    data = {
        "graph_hash": graph_hash(result.graph),
        "seed": result.seed,
        "planned_ticks": result.planned_ticks,
        "tick": memory.tick,
        "states": {name: None if x is None else [_text(v) for v in x] for name, x in memory.states.items()},
        "buffers": [[*node, [_text(v) for v in values]] for node, values in memory.buffers.items()],
        "wires": [[*node, _text(value)] for node, value in memory.wires.items()],
    }
    temporary = folder / (FILE + ".partial")
    with temporary.open("w") as file:
        json.dump(data, file)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(folder / FILE)


def load_checkpoint(folder: Path, plan: Plan, seed: int, ticks: int) -> tuple[Memory, dict[str, Any]]:
    """Memory and rows of a checkpoint; raises `ModelError` when it belongs to another graph, seed or length."""
    try:
        data = json.loads((folder / FILE).read_text())
        fits = (data["graph_hash"], data["seed"], data["planned_ticks"])
        wanted = (graph_hash(plan.graph), seed, ticks)
        if fits != wanted:
            names = ("the graph", "the seed", "the length")
            changed = [name for name, a, b in zip(names, fits, wanted, strict=True) if a != b]
            raise _refused(folder, f"{' and '.join(changed)} changed since the checkpoint", "run without --resume")
        rows = {p.signal: np.load(folder / f"{p.signal}.npy") for p in plan.probes}
        return _memory(data, plan), rows
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise _refused(folder, f"there is no {missing} to resume from", "run without --resume") from None
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, ModelError):
            raise
        raise _refused(folder, f"the checkpoint is damaged: {error}", "run without --resume") from None


def remove_checkpoint(folder: Path) -> None:
    """Take the checkpoint away once the run is whole."""
    (folder / FILE).unlink(missing_ok=True)


def _memory(data: dict[str, Any], plan: Plan) -> Memory:
    states: dict[str, Any] = {}
    for name, block in plan.blocks.items():
        made: Any = block.state_class()
        kept = data["states"][name]
        states[name] = None if made is None else made(*map(_number, kept))
    buffers = {(name, buffer): [_number(v) for v in values] for name, buffer, values in data["buffers"]}
    wires = {(name, port): _number(value) for name, port, value in data["wires"]}
    return Memory(data["tick"], states, buffers, wires)


def _text(value: Any) -> Any:
    """Floats as hexadecimal text, which keeps every bit."""
    if isinstance(value, list):
        return [_text(entry) for entry in value]
    return value.hex() if isinstance(value, float) else value


def _number(value: Any) -> Any:
    if isinstance(value, list):
        return [_number(entry) for entry in value]
    number = float.fromhex(value) if isinstance(value, str) else value
    if not math.isfinite(number):
        raise ValueError("a number is not finite")
    return number


def _refused(folder: Path, message: str, hint: str) -> ModelError:
    return ModelError([Problem(message=message, file=str(folder / FILE), hint=hint)])


