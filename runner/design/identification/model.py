"""A graph with recorded inputs, run without noise again and again with other parameters."""

from collections.abc import Mapping, Sequence

import numpy as np

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal
from proofmass.blocks.declaration.units import short_unit
from proofmass.blocks.sources.recorded_signal import RecordedSignal
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.changes import changed_blocks
from proofmass.graphs.model.flatten import flatten, inside
from proofmass.graphs.model.graph import Graph, Probe, Wire, split
from proofmass.graphs.model.names import Missing, find_output
from proofmass.runner.design.identification.recordings import RecordedStretch
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import PlannedProbe
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan, dtype_of

_ON_TICK = 1e-3  # of a step, by which a time may miss a tick


class RecordingModel:
    """Runs a graph over the inputs of one recording and gives its outputs at the recorded times."""

    def __init__(self, graph: Graph, recording: RecordedStretch, interpolated: bool, free: Sequence[str]) -> None:
        self.recording = recording
        played, buffers = _with_recorded(graph, recording, interpolated)
        self.signals = sorted(recording.outputs)
        probes = tuple(Probe(signal) for signal in self.signals)
        played = played.bare(probes=probes)
        self._adjustable = Adjustable(flatten(played))
        self.plan = plan(played, recordings=buffers, free=self._adjustable.following(free)).without_noise
        self.compiled = CompiledPlan(self.plan)
        self.ticks = max(1, int(recording.duration * float(self.plan.schedule.base_rate) * (1.0 + 1e-12) + 1e-6) + 1)
        self.rows = [np.zeros(p.rows(0, self.ticks), dtype=dtype_of(p.dtype)) for p in self.plan.probes]
        self._places = [
            _places(recording.times - probe.phase * self.plan.period, self.plan.period * probe.stride, len(rows))
            for probe, rows in zip(self.plan.probes, self.rows, strict=True)
        ]
        self.runs = 0

    def outputs(self, values: Mapping[str, float], delays: Mapping[str, float]) -> list[AnyArray] | None:
        """Return each output at the recorded times, by name; None if the run fails."""
        self.runs += 1
        try:
            changed = varied(self.plan, changed_blocks(self.plan.blocks, self._adjustable.settings(values)))
        except (ModelError, Refusal, ArithmeticError):
            return None
        loop = CompiledLoop(changed, 0, 0, start(changed), self.compiled)
        if not loop.advance(self.ticks, self.rows):
            return None
        return [
            _at(rows, *(self._delayed(probe, rows, delays[signal]) if signal in delays else place))
            for signal, probe, rows, place in zip(self.signals, self.plan.probes, self.rows, self._places, strict=True)
        ]

    def _delayed(self, probe: PlannedProbe, rows: AnyArray, delay: float) -> tuple[AnyArray, AnyArray | None]:
        """Return the places of the recorded times less a delay: straight lines between the rows."""
        late = delay + probe.phase * self.plan.period
        at = np.clip((self.recording.times - late) / (self.plan.period * probe.stride), 0.0, len(rows) - 1.0)
        before = np.minimum(at.astype(np.int64), max(len(rows) - 2, 0))
        return before, np.asarray(at - before)

    @property
    def between_ticks(self) -> bool:
        """True if some recorded time lies between two ticks of its output."""
        return any(part is not None for _, part in self._places)


def output_units(graph: Graph, signals: Sequence[str]) -> dict[str, str]:
    """Return the unit of each signal; raises `ModelError` for one that is not an output, or not a single number."""
    flat, units, problems = flatten(graph), {}, []
    for signal in signals:
        output = find_output(flat, inside(graph, signal))
        if isinstance(output, Missing):
            problems.append(Problem(message=output.message, key=signal, hint=output.hint))
        elif not output[1].is_number:
            problems.append(Problem(message="not an output that is one number", key=signal))
        else:
            units[signal] = short_unit(unit_of(*output))
    if problems:
        raise ModelError(problems)
    return units


def _with_recorded(
    graph: Graph, recording: RecordedStretch, interpolated: bool
) -> tuple[Graph, dict[str, dict[str, tuple[float, ...]]]]:
    """Return the graph with sources of the recorded inputs in place of what drives their wires."""
    units = output_units(graph, list(recording.inputs))
    blocks, wires, rates, offsets = dict(graph.blocks), list(graph.wires), dict(graph.rates), dict(graph.offsets)
    flat, buffers = flatten(graph), {}
    times = tuple(recording.times.tolist())
    for number, (signal, values) in enumerate(recording.inputs.items(), 1):
        name = next(n for n in (f"recorded_input_{number}{'x' * k}" for k in range(99)) if n not in graph.blocks)
        if not any(wire.source == signal for wire in wires):
            hint = "name the output of a source whose wires are to carry the recording"
            raise graph.placed(Problem(message="no wire begins there", key=signal, hint=hint)).error
        blocks[name] = RecordedSignal(unit=units[signal], interpolated=interpolated)
        driving = split(inside(graph, signal))[0]
        for clocks, of_blocks in ((rates, flat.rates), (offsets, flat.offsets)):
            if driving in of_blocks:
                clocks[name] = of_blocks[driving]
        wires = [Wire(f"{name}.output", w.target) if w.source == signal else w for w in wires]
        buffers[name] = {"times": times, "values": tuple(values.tolist())}
    return graph.changed(blocks=blocks, wires=tuple(wires), rates=rates, offsets=offsets), buffers


def _places(times: AnyArray, period: float, rows: int) -> tuple[AnyArray, AnyArray | None]:
    """Return the row before each time, and the part of the way to the next; None where all times lie on ticks.

    Before the first row and behind the last one it is that row.
    """
    at = times / period
    near = np.rint(at)
    if np.all(np.abs(at - near) <= _ON_TICK):
        return np.clip(near.astype(np.int64), 0, rows - 1), None
    at = np.clip(at, 0.0, rows - 1.0)
    before = np.minimum(at.astype(np.int64), max(rows - 2, 0))
    return before, np.asarray(at - before)


def _at(rows: AnyArray, before: AnyArray, part: AnyArray | None) -> AnyArray:
    if part is None:
        return rows[before]
    after = np.minimum(before + 1, len(rows) - 1)
    return np.asarray(rows[before] + part * (rows[after] - rows[before]))
