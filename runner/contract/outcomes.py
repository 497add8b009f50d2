"""Outcome of a run in plain Python, and the engines in which it differs.

Traces and memory are compared as bytes: -0.0 is not 0.0, and one NaN is as good as another. A run
that fails has to fail in every engine in the same tick.
"""

import hashlib
import struct
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.language.arithmetic import HIGHEST, LOWEST
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.contract.foreign import Foreign
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import Interpreter, TickError
from proofmass.runner.run.faults import failed
from proofmass.runner.run.recorder import room
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan, moving
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes


@dataclass(frozen=True)
class Sensor:
    """One run: a plan that differs from others in numbers alone, and the run's number, which noise follows from."""

    plan: Plan
    run: int = 0


@dataclass(frozen=True)
class Outcome:
    """A run in plain Python until its end, or until the tick in which it failed."""

    ticks: int
    rows: tuple[AnyArray, ...]
    memory: Memory
    fault: str = ""  # in the words of the graph
    error: Any = None

    def digest(self) -> str:
        """SHA-256 of traces, of everything that moves, and of the fault."""
        content = [b"".join(_bits(array).tobytes() for array in self.rows), packed(self.memory), self.fault.encode()]
        return hashlib.sha256(b"\0".join(content)).hexdigest()


def outcome(sensor: Sensor, ticks: int) -> Outcome:
    """Return what a run comes to in plain Python."""
    planned = sensor.plan
    rows = room(planned, 0, ticks)
    engine = Interpreter(planned, planned.graph.seed, sensor.run)
    try:
        engine.advance(ticks, rows)
    except TickError as error:
        before = outcome(sensor, error.tick)
        return replace(before, fault=str(failed(planned, error)), error=error)
    return Outcome(ticks, tuple(rows), engine.memory())


def packed(memory: Memory) -> bytes:
    """Return everything that moves as bytes."""
    states = {name: tuple(x) if x is not None else () for name, x in memory.states.items()}
    moves = [states, dict(memory.wires), memory.of_blocks(), memory.overflows]
    return b"".join(_packed(part[key]) for part in moves for key in sorted(part))


def _packed(value: Any) -> bytes:
    if isinstance(value, float):
        return b"nan" if value != value else struct.pack("<d", value)
    if isinstance(value, int):
        return struct.pack("<q", value) if LOWEST <= value <= HIGHEST else str(value).encode()
    return b"".join(map(_packed, value))


def native_differences(compiled: CompiledPlan, sensors: Sequence[Sensor], outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield where machine code differs."""
    for sensor, expected in zip(sensors, outcomes, strict=True):
        engine, rows = _begun(compiled, sensor), room(sensor.plan, 0, expected.ticks)
        engine.advance(expected.ticks, rows)
        yield from _unlike(sensor, rows, expected.rows)
        if packed(engine.memory()) != packed(expected.memory):
            yield _said(sensor, f"memory after {expected.ticks} ticks differs")
        if expected.fault and engine.advance(expected.ticks + 1, room(sensor.plan, 0, expected.ticks + 1)):
            yield _said(sensor, f"no fault in tick {expected.ticks}")


def resumed_differences(
    compiled: CompiledPlan, sensors: Sequence[Sensor], outcomes: Sequence[Outcome]
) -> Iterator[str]:
    """Yield where a run differs that begins in one engine and goes on in another."""
    for sensor, expected in zip(sensors, outcomes, strict=True):
        half, planned = expected.ticks // 2, sensor.plan
        first = _begun(compiled, sensor)
        first.advance(half, room(planned, 0, half))
        second = Interpreter(planned, planned.graph.seed, sensor.run, first.memory().copy())
        second.advance(expected.ticks, room(planned, 0, expected.ticks))
        if packed(second.memory()) != packed(expected.memory):
            yield _said(sensor, f"a run that is interrupted after {half} ticks ends elsewhere")


def lane_differences(
    sensors: Sequence[Sensor], outcomes: Sequence[Outcome], numbers: Mapping[Endpoint, AnyArray], lanes: int
) -> Iterator[str]:
    """Yield where runs in lanes differ; `numbers` has each varied parameter in each of them."""
    plans = [replace(sensor.plan, probes=()) for sensor in sensors]
    compiled = CompiledLanes(plans[0], frozenset(numbers), lanes)
    run = Lanes(compiled, plans[0].graph.seed, [sensor.run for sensor in sensors], numbers, plans)
    after = {o.ticks for o in outcomes} | {o.ticks + 1 for o in outcomes if o.fault}
    for tick in sorted(after):
        run.advance(tick)
        sound = run.sound()
        for number, (sensor, expected) in enumerate(zip(sensors, outcomes, strict=True)):
            if expected.ticks == tick:
                yield from (_said(sensor, text) for text in _unlike_lane(run, number, expected.memory))
            elif expected.fault and expected.ticks + 1 == tick and sound[number]:
                yield _said(sensor, f"no fault in tick {expected.ticks}")


def _unlike_lane(run: Lanes, number: int, memory: Memory) -> Iterator[str]:
    for key in run.scalars():
        if _packed(kind_of(moving(memory, key), run.value(key)[number].item())) != _packed(moving(memory, key)):
            yield f"{key} after {memory.tick} ticks is {run.value(key)[number]!r}, not {moving(memory, key)!r}"
    for node, rows in run.vectors():
        if _packed(rows[number].tolist()) != _packed(list(memory.vector(node))):
            yield f"{node} after {memory.tick} ticks differs"


def kind_of(example: Any, value: Any) -> Any:
    """A number that an array holds, as of the type that it has in plain Python."""
    return type(example)(value)


def foreign_differences(
    compiler: Foreign, compiled: CompiledPlan, sensors: Sequence[Sensor], outcomes: Sequence[Outcome]
) -> Iterator[str]:
    """Yield where the program of another compiler differs."""
    calls, expected_arrays = [], []
    for sensor, expected in zip(sensors, outcomes, strict=True):
        for last in (expected.ticks, expected.ticks + 1) if expected.fault else (expected.ticks,):
            numbers = [0, last, sensor.plan.graph.seed, sensor.run]
            calls.append((numbers, _arrays(compiled, sensor, last)))
            reference = _arrays(compiled, sensor, last)
            compiled.loop(*numbers, *(array.ctypes.data for array in reference))
            expected_arrays.append(reference)
    with tempfile.TemporaryDirectory() as folder:
        compiler.run(compiled.written.program, calls, Path(folder))
    places = iter(zip(calls, expected_arrays, strict=True))
    for sensor, expected in zip(sensors, outcomes, strict=True):
        (_, arrays), reference = next(places)
        if not same_arrays(arrays, reference):
            yield _said(sensor, f"memory or traces after {expected.ticks} ticks differ")
        if expected.fault:
            (_, arrays), _ = next(places)
            if not _failed(compiled, sensor, arrays):
                yield _said(sensor, f"no fault in tick {expected.ticks}")


def _arrays(compiled: CompiledPlan, sensor: Sensor, ticks: int) -> list[AnyArray]:
    """Everything that the program reads and writes, before the first tick."""
    rows = [
        array if len(array) else np.zeros((1, *array.shape[1:]), array.dtype) for array in room(sensor.plan, 0, ticks)
    ]
    arrays = _begun(compiled, sensor).arrays(rows)
    arrays[4].fill(np.nan)  # scratch, as the engine has it
    return arrays


def _failed(compiled: CompiledPlan, sensor: Sensor, arrays: Sequence[AnyArray]) -> bool:
    engine = _begun(compiled, sensor)
    return not engine.sound(arrays[2], arrays[3])


def _begun(compiled: CompiledPlan, sensor: Sensor) -> CompiledLoop:
    return CompiledLoop(sensor.plan, sensor.plan.graph.seed, sensor.run, start(sensor.plan), compiled)


def same_arrays(arrays: Sequence[AnyArray], others: Sequence[AnyArray]) -> bool:
    """Return whether all arrays have the same bits."""
    return all(bool((_bits(one) == _bits(other)).all()) for one, other in zip(arrays, others, strict=True))


def _bits(array: AnyArray) -> AnyArray:
    if array.dtype != np.float64:
        return array
    bits = np.ascontiguousarray(array).view(np.int64).copy()
    bits[np.isnan(array)] = -1
    return bits


def _unlike(sensor: Sensor, rows: Sequence[AnyArray], expected: Sequence[AnyArray]) -> Iterator[str]:
    for probe, got, wanted in zip(sensor.plan.probes, rows, expected, strict=True):
        unlike = _bits(got) != _bits(wanted)
        different = np.flatnonzero(unlike.any(axis=tuple(range(1, unlike.ndim))))
        if len(different):
            row = different[0]
            tick = row * probe.stride + probe.phase
            yield _said(sensor, f"{probe.signal} in tick {tick} is {got[row]!r}, not {wanted[row]!r}")


def _said(sensor: Sensor, text: str) -> str:
    return f"run {sensor.run}: {text}"
