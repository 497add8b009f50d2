"""Responses by simulation: the graph with a periodic stimulus on top of its input, less the graph without it.

Both runs have the same noise, so that what the stimulus does not move goes out. One whole
repetition is looked at, after the slowest mode has decayed: no window, no leakage.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem, shown
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert
from proofmass.blocks.signals.sum import Sum
from proofmass.blocks.sources.repeating_sequence import RepeatingSequence
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Endpoint, Graph, Probe, Wire
from proofmass.runner.analysis.linearisation.wire_response import WireResponse
from proofmass.runner.analysis.response.stimuli import OF_TONES, Repetition, Stimulus, repetitions
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.planned import Plan
from proofmass.runner.run.simulate import simulate

_DECAYED = math.log(1e6)  # of the slowest mode before a repetition counts


@dataclass(frozen=True)
class Simulated:
    """Gain of the simulation at some frequencies, and how far it is from the linear one."""

    stimulus: Stimulus
    input_unit: str
    frequencies: Array  # Hz
    gain: Complex
    linear: Complex  # gain by the linearisation at the same frequencies
    deviation: float  # rms of the difference of the outputs at these frequencies, over the rms of the linear one
    rest: float | None  # rms of what tones move at other frequencies, over the rms at their own
    ticks: int  # of each run

    @property
    def apart(self) -> Complex:
        """The gain of the simulation over the linear one."""
        return self.gain / self.linear

    @property
    def decibels(self) -> Array:
        """Difference in gain, in dB."""
        with np.errstate(divide="ignore"):  # nothing came out
            return np.asarray(20.0 * np.log10(np.abs(self.apart)))

    @property
    def degrees(self) -> Array:
        """Difference in phase, in degrees."""
        return np.asarray(np.degrees(np.angle(self.apart)))

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "stimulus": self.stimulus.kind, "amplitude": self.stimulus.amplitude, "input_unit": self.input_unit,
            "frequencies_hz": self.frequencies.tolist(), "gain": np.abs(self.gain).tolist(),
            "phase_deg": np.degrees(np.angle(self.gain)).tolist(),
            "deviation_db": [value if math.isfinite(value) else None for value in self.decibels.tolist()],
            "deviation_deg": self.degrees.tolist(),
            "deviation": self.deviation, "rest": self.rest, "ticks": self.ticks,
        }  # fmt: skip


def simulated(
    planned: Plan,
    source: Endpoint,
    target: Endpoint,
    wires: WireResponse,
    stimulus: Stimulus,
    tick: int,
    bandwidth: float | None,
    progress: Progress | None = None,
) -> Simulated:
    """Return the response by simulation from an output that is sampled; the linear one is that of `wires`."""
    bench = _Bench(planned, source, target, wires, tick)
    wanted = repetitions(stimulus, wires, bandwidth)
    quiet = bench.output(wanted[0], 0.0, _share(progress, 0, len(wanted) + 1))
    rows = []
    for number, repetition in enumerate(wanted):
        moved = bench.output(repetition, 1.0, _share(progress, number + 1, len(wanted) + 1)) - quiet
        rows.append((repetition, moved))
    return _compared(stimulus, bench, rows)


class _Bench:
    """The graph with a place for a stimulus."""

    def __init__(self, planned: Plan, source: Endpoint, target: Endpoint, wires: WireResponse, tick: int) -> None:
        _refuse(planned, source)
        self.wires, self._planned, self._source, self._target = wires, planned, source, target
        self.unit = planned.unit(source)
        self._period = round(wires.period / planned.period)  # base ticks
        decays = 0.0 < wires.radius < 1.0
        self._settled = tick + self._period * (math.ceil(_DECAYED / -math.log(wires.radius)) if decays else 1)
        self.ticks = 0

    def output(self, repetition: Repetition, factor: float, progress: Progress | None) -> Array:
        """Return the output over one repetition, once the graph has settled."""
        length = self._period * repetition.periods
        first = -(-self._settled // length) * length
        self.ticks = first + length
        graph = self._with(factor * repetition.values)
        result = simulate(graph, samples=self.ticks, progress=progress)
        if result.interrupted:
            raise KeyboardInterrupt
        skipped = self._planned.beat(self._target).before(first)
        return np.asarray(result.traces[".".join(self._target)].values[skipped:], dtype=float)

    def _with(self, values: Array) -> Graph:
        flat = flatten(self._planned.graph.root)
        signal, rate = ".".join(self._source), self._rate()
        name = _free("stimulus", flat.blocks)
        total = _free("stimulated", flat.blocks)
        added = {name: RepeatingSequence(values=values.tolist(), unit=self.unit), total: Sum(unit=self.unit)}
        offsets = dict(flat.offsets)
        if self._source[0] in offsets:
            offsets |= dict.fromkeys((name, total), offsets[self._source[0]])
        wires = [Wire(f"{total}.output" if w.source == signal else w.source, w.target) for w in flat.wires]
        wires += [Wire(signal, f"{total}.first"), Wire(f"{name}.output", f"{total}.second")]
        return flat.as_graph().bare(
            blocks={**flat.blocks, **added},
            rates={**flat.rates, name: rate, total: rate},
            offsets=offsets,
            wires=tuple(wires),
            probes=(Probe(".".join(self._target)),),
        )

    def _rate(self) -> Fraction:
        return self._planned.schedule.base_rate / self._planned.stride(self._source)


def _compared(stimulus: Stimulus, bench: _Bench, rows: list[tuple[Repetition, Array]]) -> Simulated:
    """Return the gains at the lines of all repetitions, beside those of the linear map for the same stimulus."""
    wires, frequencies, gains, linear = bench.wires, [], [], []
    apart = expected = rest = moved = 0.0
    for repetition, output in rows:
        f = repetition.frequencies(wires.period)
        out, _ = wires.turns(f)
        lifted = np.einsum("fik,fk->fi", wires.lifted(f), repetition.spectrum(wires.entries))
        predicted = np.einsum("fi,fi->f", out, lifted) / wires.values
        shown = np.fft.fft(output)[repetition.lines] * out[:, 0] / len(output)
        gain = wires.gain(f)
        frequencies.append(f)
        linear.append(gain)
        gains.append(gain * shown / predicted)
        apart += float(np.sum(np.abs(shown - predicted) ** 2))
        expected += float(np.sum(np.abs(predicted) ** 2))
        moved += float(np.sum(np.abs(shown) ** 2)) * 2.0
        rest += float(np.var(output))
    return Simulated(
        stimulus,
        bench.unit,
        np.concatenate(frequencies),
        np.concatenate(gains),
        np.concatenate(linear),
        math.sqrt(apart / expected),
        math.sqrt(max(rest - moved, 0.0) / moved) if stimulus.kind in OF_TONES and moved else None,
        bench.ticks,
    )


def read_amplitude(planned: Plan, source: Endpoint, amplitude: str | float | None) -> float:
    """Return the peak value of a stimulus in the unit of the input; raises `ModelError` for any other text."""
    unit = planned.unit(source)
    expected = f"a quantity in {unit}" if unit != "1" else "a number"
    got = shown(amplitude) if amplitude is not None else ""
    hint = "small for the response to small signals, yet well above a step of a converter"
    try:
        if amplitude is not None:
            value = convert(amplitude, unit) if isinstance(amplitude, str) else float(amplitude)
            if 0.0 < value < math.inf:
                return value
    except UnitError as error:
        hint = error.hint if unit != "1" else "the input has no unit"
    message = "the stimulus needs an amplitude" if amplitude is None else "is not an amplitude"
    raise Problem(message=message, key="amplitude", got=got, expected=expected, hint=hint).error


def _share(progress: Progress | None, number: int, runs: int) -> Progress | None:
    """Progress of one run as part of that of all of them, which take alike long."""
    return None if progress is None else lambda done, of: progress(number * of + done, runs * of)


def _free(name: str, blocks: Mapping[str, Block]) -> str:
    """Return a name that no block has."""
    while name in blocks:
        name += "_"
    return name


def _refuse(planned: Plan, source: Endpoint) -> None:
    block = planned.blocks[source[0]]
    signal, port = ".".join(source), type(block).outputs[source[1]]
    hint = "choose the output of a source, or of a block with a rate of its own"
    problem = None
    if type(block).continuous():
        problem = Problem(message="a stimulus cannot be added between continuous blocks", key=signal, hint=hint)
    elif port.dtype is not float:
        problem = Problem(message="a stimulus cannot be added to codes", key=signal, got=port.dtype.__name__, hint=hint)
    if problem:
        raise planned.graph.placed(problem.at(*planned.graph.find(("blocks", source[0])))).error
