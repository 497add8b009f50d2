"""An interrupted run on disk: what moves, and recorded rows, to go on from to the same bits."""

import hashlib
import json
import math
import os
from array import array
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.host.named_files import named
from proofmass.runner.plan.keys import VectorOf
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan, PlannedProbe
from proofmass.runner.plan.solver import Solver
from proofmass.runner.run.beginning import code_of
from proofmass.runner.run.provenance import graph_text
from proofmass.runner.run.recorder import Recorder
from proofmass.runner.run.result import Result, pieces

FILE = "checkpoint.json"  # of an interrupted run, in its folder
HEAD = 10  # bytes of a .npy file before its head, the last two its length
VERSION = 2  # of its form; the first had no check sums
_ANEW = "--restart, or resume=False in Python, removes what was kept and starts at tick 0"


def is_interrupted(folder: Path) -> bool:
    """Return whether a folder holds a run that was interrupted."""
    return (folder / FILE).is_file()


class Checkpoint(NamedTuple):
    """State a run resumes from: its memory, and the number of rows of each trace in the folder."""

    memory: Memory
    rows: Mapping[str, int]


def save_checkpoint(result: Result, planned: Plan, folder: Path) -> None:
    """Write the memory of an interrupted run and its traces as `.npy` files into the folder."""
    memory = result.memory
    if memory is None:
        raise ValueError("the run was not interrupted")
    for trace in result.traces.values():
        path = written = _trace(folder, trace.signal)
        streamed = isinstance(trace.values, np.memmap)
        if not streamed:  # an earlier checkpoint goes on from what is there
            written = path.with_suffix(".npy.partial")
        with named(path), written.open("r+b" if streamed else "wb") as file:
            if not streamed:
                np.save(file, trace.values)
                file.flush()
            os.fsync(file.fileno())
        written.replace(path)
    rows = {probe.signal: probe.rows(0, memory.tick) for probe in planned.probes}
    data = {
        "version": VERSION,
        "run": _run(planned, result.seed, result.planned_ticks),
        "tick": memory.tick,
        "rows": rows,
        "sums": {probe.signal: _sum_of(_rows(folder, probe, rows[probe.signal])) for probe in planned.probes},
        "states": {name: None if x is None else [_text(v) for v in x] for name, x in memory.states.items()},
        "buffers": [[*node, _text(held)] for node, held in memory.of_blocks().items() if node not in planned.recorded],
        "largest": {solver.name: _text(memory.buffers[solver.largest]) for solver in _with_largest(planned)},
        "overflows": memory.overflows,
        "wires": [[*node, _text(value)] for node, value in memory.wires.items()],
    }
    temporary = folder / (FILE + ".partial")
    with named(temporary), temporary.open("w", encoding="utf-8") as file:
        json.dump(data | {"sum": _sum(data)}, file)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(folder / FILE)


def load_checkpoint(folder: Path, planned: Plan, seed: int, ticks: int) -> Checkpoint:
    """The checkpoint in a folder.

    Raises `ModelError` when it belongs to another graph, seed or length, or when it or a trace
    differs from its sum.
    """
    try:
        data = json.loads((folder / FILE).read_text(encoding="utf-8"))
        if data["version"] != VERSION:
            raise _refused(folder, "the checkpoint has another form", str(data["version"])[:20], f"version {VERSION}")
        if data.pop("sum") != _sum(data):
            raise ValueError("it differs from its check sum")
        kept, wanted = data["run"], _run(planned, seed, ticks)
        if kept != wanted:
            raise _changed(folder, kept, wanted)
        for probe in planned.probes:
            if _sum_of(_rows(folder, probe, data["rows"][probe.signal])) != data["sums"][probe.signal]:
                raise ValueError(f"{probe.signal}.npy differs from its check sum")
        return Checkpoint(_memory(data, planned), data["rows"])
    except FileNotFoundError as error:
        raise _refused(folder, f"there is no {Path(error.filename).name} to resume from") from None
    except (LookupError, TypeError, ValueError, AttributeError, RecursionError) as error:
        if isinstance(error, ModelError):
            raise
        raise _refused(folder, f"the checkpoint is damaged: {error}") from None


def remove_checkpoint(result: Result, folder: Path) -> None:
    """Take the checkpoint away once the run is whole, and with it the traces that are results of another form."""
    if not (folder / FILE).exists():
        return
    (folder / FILE).unlink()
    for trace in result.traces.values():
        if not isinstance(trace.values, np.memmap):
            _trace(folder, trace.signal).unlink(missing_ok=True)


def recorder(probe: PlannedProbe, rows: int, folder: Path, streamed: bool, rows_kept: int) -> Recorder:
    """A recorder that goes on behind the first rows in a folder; a file of rows is not copied."""
    if not streamed:
        writer = Recorder(probe, rows, None)
        writer.keep(_rows(folder, probe, rows_kept))
        return writer
    return Recorder(probe, rows, folder, rows_kept)


def _run(planned: Plan, seed: int, ticks: int) -> dict[str, Any]:
    """Return what two runs must share to give the same bits."""
    recordings = hashlib.sha256()
    for node in sorted(planned.recorded):
        recordings.update(array("d", planned.buffers[node]).tobytes())
    return {
        "graph": graph_text(planned.graph.as_graph()),
        "the seed": seed,
        "the number of ticks": ticks,
        "the recordings": recordings.hexdigest(),
        "the program or the code of a block": code_of(planned),
    }


def _changed(folder: Path, stored: Mapping[str, Any], current: Mapping[str, Any]) -> ModelError:
    if stored["graph"] != current["graph"]:
        before, now = _lines(stored["graph"]), _lines(current["graph"])
        got, expected = (", ".join(line for line in a if line not in b) for a, b in ((now, before), (before, now)))
        return _refused(folder, "the graph changed since the checkpoint", got, expected)
    name = next(name for name in current if stored[name] != current[name])
    shown = (str(current[name]), str(stored[name])) if isinstance(current[name], int) else ("", "")
    return _refused(folder, f"{name} changed since the checkpoint", *shown)


def _lines(text: str) -> list[str]:
    """The lines of a graph file, each behind the head of its table."""
    head, lines = "", []
    for line in text.splitlines():
        if line.startswith("["):
            head = f"{line} "
        else:
            lines.append(head + line.strip(" ,"))
    return lines


def _memory(data: dict[str, Any], planned: Plan) -> Memory:
    states: dict[str, Any] = {}
    for name, block in planned.blocks.items():
        made: Any = type(block).state_class()
        states[name] = None if made is None else made(*map(_number, data["states"][name]))
    buffers: dict[VectorOf, Any] = {(name, buffer): _number(held) for name, buffer, held in data["buffers"]}
    buffers |= {solver.largest: _number(data["largest"][solver.name]) for solver in _with_largest(planned)}
    buffers |= {node: planned.buffers[node] for node in planned.recorded}
    wires = {(name, port): _number(value) for name, port, value in data["wires"]}
    overflows = {name: int(data["overflows"][name]) for name in planned.digital if name in data["overflows"]}
    return Memory(data["tick"], states, buffers, wires, overflows)


def _with_largest(planned: Plan) -> list[Solver]:
    """The groups whose largest values are kept."""
    return [solver for solver in planned.solvers if solver.largest in planned.buffers]


def _text(value: Any) -> Any:
    """Floats as hexadecimal text, which keeps every bit."""
    if isinstance(value, list):
        return [_text(entry) for entry in value]
    return value.hex() if isinstance(value, float) else value


def _number(value: Any) -> Any:
    if isinstance(value, list):
        return [_number(entry) for entry in value]
    return float.fromhex(value) if isinstance(value, str) else value


def _trace(folder: Path, signal: str) -> Path:
    return folder / f"{signal}.npy"


def _bytes(probe: PlannedProbe, rows: int) -> int:
    return rows * math.prod(probe.shape) * np.dtype(probe.dtype).itemsize


def _rows(folder: Path, probe: PlannedProbe, rows: int) -> AnyArray:
    """The first rows of a trace on disk. Its head is passed over: it may tell more rows; the plan knows the rest."""
    path, kind = _trace(folder, probe.signal), np.dtype(np.float64 if probe.format else probe.dtype)
    with path.open("rb") as file:
        start = HEAD + int.from_bytes(file.read(HEAD)[-2:], "little")
    if path.stat().st_size < start + _bytes(probe, rows):
        raise ValueError(f"{path.name} is too short")
    shape = (rows, *probe.shape)
    return np.memmap(path, kind, "r", start, shape) if rows else np.empty(shape, kind)


def _sum_of(values: AnyArray) -> str:
    """The check sum of rows: SHA-256 of every bit of them, also those of NaN."""
    digest = hashlib.sha256()
    for first, last in pieces(len(values), math.prod(values.shape[1:])):
        digest.update(values[first:last].tobytes())
    return digest.hexdigest()


def _sum(data: dict[str, Any]) -> str:
    """The check sum of what JSON keeps."""
    return hashlib.sha256(json.dumps(data).encode()).hexdigest()


def _refused(folder: Path, message: str, got: str = "", expected: str = "") -> ModelError:
    place = str(folder / FILE)
    problem = Problem(message=message, file=place, got=got[:200], expected=expected, hint=_ANEW)
    return problem.error
