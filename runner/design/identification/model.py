"""A graph with recorded inputs, run without noise again and again with other parameters."""

import math
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
from proofmass.runner.plan.groups import moving
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
        self._moving = moving(self.plan.graph, self.plan.schedule)
        self._places = [self._place(*each, None) for each in zip(self.plan.probes, self.rows, strict=True)]
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
            _at(rows, *(self._place(probe, rows, delays[signal]) if signal in delays else place))
            for signal, probe, rows, place in zip(self.signals, self.plan.probes, self.rows, self._places, strict=True)
        ]

    def _place(self, probe: PlannedProbe, rows: AnyArray, delay: float | None) -> tuple[AnyArray, AnyArray | None]:
        """Return the row before each recorded time, less a delay if there is one, and the part of the way to the next.

        The part is None where all rows are at a tick or hold from there. An output that moves between
        ticks does so on straight lines. With a delay one that holds goes over to its next value while
        the widest gap between the recorded places in a period passes: what is recorded does not tell
        when, and a search needs a slope.
        """
        period, last = self.plan.period * probe.stride, len(rows) - 1
        at, ticks, parts = self._ticks(probe)
        held = probe.node not in self._moving
        if delay is None and (held or not np.any(parts)):
            return np.clip(ticks, 0, last), None
        over = _widest_gap(parts) if held else 1.0
        at = np.clip(at - (delay or 0.0) / period, 0.0, float(last))
        before = np.minimum(at.astype(np.int64), max(last - 1, 0))
        return before, np.asarray(np.clip((at - before + over - 1.0) / over, 0.0, 1.0))

    def _ticks(self, probe: PlannedProbe) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Return the recorded times in periods of an output, the ticks before them, and the part of a period since."""
        at = (self.recording.times - probe.phase * self.plan.period) / (self.plan.period * probe.stride)
        ticks = np.floor(at + _ON_TICK)
        parts = at - ticks
        return at, ticks.astype(np.int64), np.where(np.abs(parts) > _ON_TICK, parts, 0.0)

    def least_error(self, signal: str) -> float:
        """Return the least standard error of a delay: rows do not tell when an output that holds goes over.

        Rows at its ticks alone are taken for samples of what moves on lines.
        """
        probe = self.plan.probes[self.signals.index(signal)]
        gap = 0.0 if probe.node in self._moving else _widest_gap(self._ticks(probe)[2])
        return gap * self.plan.period * probe.stride / math.sqrt(12.0) if gap < 1.0 else 0.0

    @property
    def between_ticks(self) -> bool:
        """True if some recorded time lies between two ticks of an output that moves there."""
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


def _widest_gap(parts: AnyArray) -> float:
    """Return the widest gap between places in a period, from 0 to 1, which come round."""
    ordered = np.unique(parts)
    return float(np.max(np.diff(np.append(ordered, ordered[0] + 1.0))))


def _at(rows: AnyArray, before: AnyArray, part: AnyArray | None) -> AnyArray:
    if part is None:
        return rows[before]
    after = np.minimum(before + 1, len(rows) - 1)
    return np.asarray(rows[before] + part * (rows[after] - rows[before]))
